"""Stamps and rates to one time axis with its gaps."""
