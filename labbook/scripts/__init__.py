"""Stand-alone scripts that compute one number of a report from what was measured: Python or R, with a table."""
