"""Contact: external torque and flange force from an identified model, with a threshold that is a rate.

In: a fit, samples of a live arm or a recording, runs without contact.
Out: `Estimates`, a `Threshold`, alarms.
"""

BANDWIDTH = 5.0
"""Bandwidth of the observer [Hz]: 63 % of a step after 32 ms, and 16 ms more for the low-pass before it.
It is here so that command lines do not import the observer for it."""
