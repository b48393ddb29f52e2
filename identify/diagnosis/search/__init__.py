"""The search for what is missing.

In: runs and all candidates.
Out: `Searched`: findings, their alternatives, and the prediction with them.
"""
