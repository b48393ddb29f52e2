"""Effects added to public recordings of real arms, one at a time.

In: recordings in `EXIDYN_DATA`.
Out: the same recordings with the torque of one more effect, by formulas of their own.
"""
