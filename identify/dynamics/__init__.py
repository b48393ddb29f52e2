"""Torque and momentum of a model at given values, from scalars: numbers, arrays of samples, or symbols.

In: a model, its values, a joint state.
Out: joint torque, generalized momentum.
"""
