"""Parts: what several candidates are made of."""
