"""Studies of the thesis, each from what was measured to its verdict."""
