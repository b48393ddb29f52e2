"""What `exidyn example` lays out and says.

In: nothing.
Out: robots, plans and steps.
"""
