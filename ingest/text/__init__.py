"""Bytes to lines and cells: encodings, line ends, delimiters, the value of a cell."""
