"""The search for what is missing.

In: runs and all candidates.
Out: `SearchResult`: findings, their alternatives, and the prediction with them.
"""
