"""The arm with what was found.

In: `Diagnosis`.
Out: models, and simulations of its runs.
"""
