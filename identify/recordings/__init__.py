"""Recordings, read from MCAP files and from files of other tools, with units, checks and warnings.

Errors are a `RecordingError`, whose message names the file, the place in it, and what is valid.
"""
