"""Recordings, fits and diagnoses in Rerun, one layout a kind.

In: files.
Out: a view.
"""
