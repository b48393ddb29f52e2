"""The rigid arm.

In: a Pinocchio model, limits, gear ratios, drive gains; motions.
Out: `Robot`, `Motion`, torques, regressors and their gradients.
"""
