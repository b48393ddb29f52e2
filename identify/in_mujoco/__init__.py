"""An arm in MuJoCo, in the user's own simulation.

In: a compiled MJCF, a model with values.
Out: forces that MJCF lacks, in every step.
"""
