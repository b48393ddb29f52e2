"""Exciting trajectories of exidyn and of others, and their judge.

In: an arm, limits, time to search.
Out: condition numbers, deviations, probabilities of choosing right.
"""
