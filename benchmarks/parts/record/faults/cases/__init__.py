"""The faults of controllers, links and people, each with what must happen and why.

In: nothing.
Out: `FAULTS`, in the order of the table.
"""

from . import can, franka, kuka_rsi, people, serial, ur_rtde

FAULTS = (
    *kuka_rsi.FAULTS,
    *ur_rtde.FAULTS,
    *franka.FAULTS,
    *can.FAULTS,
    *serial.FAULTS,
    *people.FAULTS,
)
