"""Several groups: analysis of variance, all pairs, many to one, how groups scatter."""
