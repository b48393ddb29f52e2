"""What `exidyn example` writes and prints.

In: nothing.
Out: robots, plans and steps.
"""
