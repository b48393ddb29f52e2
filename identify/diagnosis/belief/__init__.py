"""Belief: what a diagnosis leaves open, and what a further run would settle.

In: a search, and the columns of runs that could be made.
Out: probabilities of the answers to each open question, and how much entropy each run would leave.
"""
