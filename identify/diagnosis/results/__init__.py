"""Results of a search about its runs.

In: `SearchResult`.
Out: the budget of the misfit, what is left, deviations, evidence.
"""
