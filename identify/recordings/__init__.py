"""From MCAP files and what other tools write to a `Recording`, with units, checks and warnings."""
