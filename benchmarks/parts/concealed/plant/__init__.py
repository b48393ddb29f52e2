"""The simulated arm, which shares no formulas with what is under test.

In: a `Machine`, a path, disturbances.
Out: a `Log` of positions, currents and temperatures at 500 Hz.
"""
