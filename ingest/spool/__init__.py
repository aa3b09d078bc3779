"""Large data outside memory: bytes and columns in temporary files without a name, mapped and read in blocks."""
