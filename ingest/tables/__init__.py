"""Lines to tables: header, units, preamble, where the data begin and end, rows as columns of numbers."""
