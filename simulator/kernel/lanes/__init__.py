"""Many jumps of one effect set side by side, in lanes of vector registers."""
