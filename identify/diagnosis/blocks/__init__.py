"""Blocks of runs, each left out and predicted by the others.

In: rows.
Out: `Prediction`: unknowns, predicted errors, their probability.
"""
