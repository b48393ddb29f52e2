"""Runs as the diagnosis asks of them.

In: recordings and a model.
Out: torque and load at every sample; rows with the columns of all unknowns.
"""
