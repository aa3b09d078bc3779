"""The language of `--where`: its words, its grammar, and the condition that a database evaluates."""
