"""Other copies of a book: backups, and its rows in another database."""
