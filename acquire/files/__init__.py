"""Files that several commands read and write."""
