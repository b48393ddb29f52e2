"""Built-in robots, one robot file each, read by name."""
