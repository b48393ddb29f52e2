"""Simulation.

In: a model with parameter values, and motions.
Out: torques, recordings, and their differences from real recordings.
"""
