"""What drivers on a CAN bus share.

In: settings of an interface.
Out: a bus, its load, and one exchange a cycle.
"""
