"""The page of a fleet.

In: reports of the types of arms, links to recordings.
Out: HTML that needs nothing else.
"""
