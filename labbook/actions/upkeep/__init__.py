"""The book as a whole: checked, merged, restored, pruned, traced to its bytes."""
