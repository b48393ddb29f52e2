"""Contact: external torque and flange force from an identified model, with a threshold that is a rate.

In: a fit, samples of a live arm or a recording, runs without contact.
Out: `Estimates`, a `Threshold`, alarms.
"""
