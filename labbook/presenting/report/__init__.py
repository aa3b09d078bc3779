"""The content of a report."""
