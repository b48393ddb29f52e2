"""Arms and recordings in Rerun.

In: models, recordings.
Out: what is logged.
"""
