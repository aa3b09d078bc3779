"""Files in the instruments' own formats, one writer a format; each returns bytes.

What they write is synthetic. None of the formats but `labbook.toml` and the run sheet has a place to say so, so
the names of the files do.
"""
