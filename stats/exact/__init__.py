"""Arithmetic behind the rest: sums, tails, quantiles and integrals whose digits hold."""
