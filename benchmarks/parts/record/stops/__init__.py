"""Stops: what a quick stop does while a joint's position is read wrongly, on every driver.

In: a driver with its peer, and what its sensors show.
Out: how far the arm moved that neither its commands nor its stopping distance explain.
"""
