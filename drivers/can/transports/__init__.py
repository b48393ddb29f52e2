"""How frames get to a CAN adapter and from it, one file an interface of python-can.

In: an open bus of python-can.
Out: identifiers and data.
"""
