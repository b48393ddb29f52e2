"""Belief: the questions that a diagnosis leaves open, and how far a further run would answer them.

In: a search, and the columns of runs that could be made.
Out: probabilities of the answers to each open question, and the entropy that each run would leave.
"""
