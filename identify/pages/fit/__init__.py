"""The report of a fit.

In: `Fit`.
Out: its summary as text, its page as HTML.
"""
