"""A book: opening it, writing to it, making, upgrading and rebuilding it."""
