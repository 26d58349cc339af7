"""Media, layers and what a stack of them does to light."""
