"""Arguments as they come from users: checked, named in errors, broadcast."""
