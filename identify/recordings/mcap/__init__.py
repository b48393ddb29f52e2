"""MCAP files.

In: bytes, also of a run that was cut off.
Out: `Recording`, and bytes again.
"""
