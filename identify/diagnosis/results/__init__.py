"""What a search says of its runs.

In: `Searched`.
Out: the budget of the misfit, what is left, deviations, evidence.
"""
