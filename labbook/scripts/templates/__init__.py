"""The parts of stand-alone scripts: Python that a script takes functions from, and that imports nothing of labbook.

Imports of other templates are left out of a script, which has the functions themselves.
"""
