"""The instruments' files: reading them, assigning them, reading them again."""
