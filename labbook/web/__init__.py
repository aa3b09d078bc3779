"""The book as a page in a browser of this machine: look, judge, see what is wrong."""
