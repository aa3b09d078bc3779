"""A table, or numbers, as a file: one format each."""
