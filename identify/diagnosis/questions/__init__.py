"""What a candidate would add.

In: a prediction, and columns of candidates.
Out: `Answer`: gain, coefficients, odds by block and joint.
"""
