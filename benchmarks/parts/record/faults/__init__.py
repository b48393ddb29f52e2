"""What goes wrong in a run, and whether it ends as it must.

In: a fault and the moment it happens.
Out: a row a fault: what must happen, what did.
"""
