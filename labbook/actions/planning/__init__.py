"""Before measuring: the order of runs, and how many are needed."""
