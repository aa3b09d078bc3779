"""One sample or two: descriptions, tests, differences, savings, equivalence, errors that are shared."""
