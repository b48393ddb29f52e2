"""What a search says of its runs.

In: `SearchResult`.
Out: the budget of the misfit, what is left, deviations, evidence.
"""
