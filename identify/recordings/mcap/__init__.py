"""MCAP files: from bytes, also of a run that was cut off, to a `Recording`, and back."""
