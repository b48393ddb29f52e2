"""What may be wrong with a robot: the vocabulary, and what has no name in it.

In: a `Robot`, a joint, a strength, random numbers.
Out: `Concealed`: the robot with the effect, the same without it, parameters.
"""
