"""Stops that do not work, in every stage of a run.

In: a stage, a fault of the drives, an arm with or without mass.
Out: which stop is asked for, and when.
"""
