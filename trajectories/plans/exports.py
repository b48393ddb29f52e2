"""A plan as the text of other programs' files: a function a format, in a table."""

import json
from collections.abc import Callable

import numpy as np

from ..trajectory import States
from .export_points import fixed, points
from .krl import krl_text
from .plan import Plan

ROS_RATE = 50.0
"""Points a second: a controller that joins them by quintic splines meets them within a thousandth of the
motion, and a minute stays a file that an editor opens [Hz]."""
DIGITS = 9
"""Behind the point: a nanoradian, far below any encoder."""

Export = Callable[[Plan, float | None], str]


def csv_text(plan: Plan, rate: float | None = None) -> str:
    """Table of time [s], positions q, velocities v, accelerations a; at every tick, SI units."""
    states = points(plan, rate or 1.0 / plan.tick, end=False)
    joints = range(1, plan.trajectory.dof + 1)
    head = ["t", *(f"{letter}{joint}" for letter in "qva" for joint in joints)]
    columns = [states.time[:, None], states.position, states.velocity, states.acceleration]
    rows = [",".join(map(repr, row)) for row in np.concatenate(columns, axis=1).tolist()]
    return "\n".join([",".join(head), *rows]) + "\n"


def ros_text(plan: Plan, rate: float | None = None) -> str:
    """ROS 2 trajectory_msgs/JointTrajectory as YAML for `ros2 topic pub`; 50 points a second."""
    states = points(plan, rate or ROS_RATE)
    lines = [
        f"# {plan.robot}, {plan.trajectory.duration:.9g} s, planned by exidyn. To send it once:",
        '# ros2 topic pub --once TOPIC trajectory_msgs/msg/JointTrajectory "$(cat THIS_FILE)"',
        *_ros_remarks(states),
        'header: {stamp: {sec: 0, nanosec: 0}, frame_id: ""}',
        f"joint_names: {json.dumps(plan.joints, ensure_ascii=False)}",
        "points:",
    ]
    for row, time in enumerate(states.time):
        nanoseconds = round(time * 1e9)
        lines += [
            f"- positions: {_numbers(states.position[row])}",
            f"  velocities: {_numbers(states.velocity[row])}",
            f"  accelerations: {_numbers(states.acceleration[row])}",
            f"  time_from_start: {{sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}}}",
        ]
    return "\n".join(lines) + "\n"


def _ros_remarks(states: States) -> list[str]:
    """What a controller would refuse."""
    remarks = []
    for row, place, what in (
        (0, "starts", "bring it there at that speed"),
        (-1, "ends", "it must allow that"),
    ):
        if np.any(np.abs(states.velocity[row]) > 10.0**-DIGITS):
            remarks.append(f"# It {place} in motion: a joint_trajectory_controller needs to know; {what}.")
    return remarks


def _numbers(values: np.ndarray) -> str:
    return f"[{', '.join(fixed(value, DIGITS) for value in values)}]"


EXPORTS: dict[str, Export] = {"csv": csv_text, "ros": ros_text, "krl": krl_text}
"""Name of a format -> its text, of a plan and the points a second; None for the format's own rate."""
