"""Diagnosis of public recordings with plain priors.

In: recordings in `EXIDYN_DATA`, what is known of their arms.
Out: names beside what is known.
"""
