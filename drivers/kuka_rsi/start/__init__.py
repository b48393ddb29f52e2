"""The start of a session.

In: the first telegrams.
Out: where the arm stands, and what the controller makes of corrections.
"""
