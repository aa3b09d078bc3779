"""Bytes to lines and cells: encodings, line ends, delimiters, what one cell says."""
