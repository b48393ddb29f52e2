"""Documents: the content of a report, and renderers that are independent of physics."""
