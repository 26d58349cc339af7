"""One module a format: what others wrote, as the tree of a scene."""
