"""Which conditions are compared, and what the comparisons say."""
