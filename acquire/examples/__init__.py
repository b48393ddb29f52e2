"""What `exidyn example` writes and prints: robots, plans and steps."""
