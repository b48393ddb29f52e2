"""Default bandwidth of the observer, apart so that command lines do not import the observer for it."""

BANDWIDTH = 5.0
"""Bandwidth of the observer [Hz]: 63 % of a step after 32 ms, and 16 ms more for the low-pass before it."""
