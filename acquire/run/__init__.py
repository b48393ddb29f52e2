"""One run on a controller, from the first sample to the last stop."""
