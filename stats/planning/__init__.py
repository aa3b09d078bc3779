"""Before an experiment: power, sample size, and known error rates of the tests."""
