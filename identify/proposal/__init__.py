"""What a log seems to hold, and how sure that is.

In: columns with names, as arrays, and the robot as described.
Out: a `Proposal`: which column is what, in which unit, and rough drive gains, each with a probability.
"""
