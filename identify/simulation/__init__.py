"""Simulation.

In: a model with values, and motions.
Out: torques, recordings, and how they differ from what was recorded.
"""
