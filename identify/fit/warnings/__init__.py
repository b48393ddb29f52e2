"""What a fit should be doubted for.

In: `Fit` and its runs.
Out: sentences.
"""
