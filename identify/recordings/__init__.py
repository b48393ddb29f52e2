"""Recordings, read from MCAP files and from files of other tools, with units, checks and warnings."""
