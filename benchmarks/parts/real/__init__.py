"""Public recordings of a UR10e, a KR300 and a Panda.

In: recordings in `EXIDYN_DATA`.
Out: held-out residuals by model and estimator, payloads.
"""
