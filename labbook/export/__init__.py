"""What leaves a book: tables as frames, files of tables and samples, for Python, R and spreadsheets."""
