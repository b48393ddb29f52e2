"""An identified arm in the user's own MuJoCo simulation.

In: a compiled MJCF, a model with parameter values.
Out: forces that MJCF cannot express, applied in every step.
"""
