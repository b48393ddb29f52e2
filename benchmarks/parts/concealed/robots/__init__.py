"""Three arms, as they are and as their owners believe them to be.

In: the name of an arm, random numbers.
Out: `Robot`: a machine, a prior, a recorder.
"""
