"""The six studies of the thesis: each a file with its question, its arithmetic, its words and its figure."""
