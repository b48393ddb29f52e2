"""Warnings about a fit.

In: `Fit` and its runs.
Out: sentences.
"""
