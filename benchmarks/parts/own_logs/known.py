"""What is known of a log."""

from dataclasses import dataclass

import numpy as np

DIRECT = """<robot name="motor">
<link name="stator"/>
<joint name="rotor" type="continuous">
<parent link="stator"/><child link="body"/><axis xyz="0 0 1"/><limit velocity="200" effort="10"/>
</joint>
<link name="body"><inertial>
<mass value="0.1"/><inertia ixx="2e-4" iyy="2e-4" izz="1.8e-4" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
</robot>
"""
"""The motor of odrive_spin_slow without a gear: the one in its robot.toml is fictitious."""


@dataclass(frozen=True)
class Known:
    """What is true of a log.

    Attributes:
        time: Unit.
        position: Unit.
        velocity: Unit a second, "" without velocities.
        effort: "torque" of the joints, "current" for anything that needs a gain, "command" where there is
            none and servos follow commands; "" where nobody knows.
        gain: Of the drives [N m per unit], shape (n,); None where nobody knows.
        columns: Names by signal in the order of the robot's joints, those that must be found.
        gravity: Whether the arm is known to stand as it is described.
    """

    time: str
    position: str
    velocity: str
    effort: str
    gain: np.ndarray | None
    columns: dict[str, list[str]]
    gravity: bool = True
