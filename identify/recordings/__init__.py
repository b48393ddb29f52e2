"""Recordings of runs.

In: MCAP files and what other tools write.
Out: `Recording`, with units, checks and warnings.
"""
