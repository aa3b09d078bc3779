"""Simulations as lines, tables and data."""
