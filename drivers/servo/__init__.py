"""What drivers of servos on a serial port share.

In: a port, packets.
Out: one exchange a cycle.
"""
