"""Columns to channels: which quantity, which unit, which sign, and whether the values are plausible."""
