"""Three arms, as they are, and nominal.

In: the name of an arm, random numbers.
Out: `Robot`: a machine, a prior, a recorder.
"""
