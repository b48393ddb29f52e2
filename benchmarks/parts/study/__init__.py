"""Small arms with something concealed, studied.

In: a case by its number.
Out: what was concealed, what the study and the fixed programme found, and how long the arm moved.
"""
