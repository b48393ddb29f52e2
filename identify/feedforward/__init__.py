"""Torque to command ahead of the controller, from a fit, as files that do not need exidyn.

In: a fit.
Out: `Feedforward`: gravity, friction and inverse dynamics; a Python file, a C++ header.
"""
