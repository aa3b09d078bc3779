"""A book: opening it, writing to it, making and rebuilding it."""
