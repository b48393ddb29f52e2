"""One run on a controller, from the first sample to the last stop.

In: a driver, a motion, limits.
Out: how it went; every cycle, handed over.
"""
