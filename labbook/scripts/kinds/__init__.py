"""Kinds of numbers that a script can compute, each a file: which functions of the templates, of which rows."""
