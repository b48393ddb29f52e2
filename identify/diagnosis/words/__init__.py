"""A diagnosis as sentences and as plain tables."""
