"""`labbook stats`: tests on a table or on the book."""
