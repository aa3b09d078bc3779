"""Arrays in, numbers out: statistics of runs, and jumps and apexes of height logs. No database, no files."""
