"""Size of the package: its source, and what is entered on the way through it.

In: a checkout.
Out: counts.
"""
