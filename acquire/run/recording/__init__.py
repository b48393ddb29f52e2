"""The process that records a run.

In: frames.
Out: an MCAP file that is whole, or what a crash left of it.
"""
