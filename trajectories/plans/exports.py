"""Export of plans to formats of other programs (CSV, ROS, KRL), one function for each."""

from collections.abc import Callable

import numpy as np

from exidyn.quoting import double_quoted, hash_comment, krl_comment, krl_name

from ..errors import BadLimits
from ..trajectory import States
from .plan import Plan


def points(plan: Plan, rate: float, end: bool = True) -> States:
    """States at a rate [Hz]; with `end`, the end of the motion is the last one."""
    states = plan.trajectory.every(1.0 / rate)
    remaining = plan.trajectory.duration - states.time[-1]
    # less than a thousandth of a step is rounding
    if not end or remaining < 1e-3 / rate:
        return states
    return plan.trajectory.at(np.append(states.time, plan.trajectory.duration))


def fixed(value: float, digits: int) -> str:
    """A number with fixed decimals and no exponent, which YAML 1.1 and KRL read alike; no minus zero."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"


KRL_RATE = 2.0
"""Rate of points [Hz]: a point-to-point motion cannot follow faster swings."""
KRL_AXES = (*(f"A{i}" for i in range(1, 7)), *(f"E{i}" for i in range(1, 7)))
"""Axes of an E6AXIS."""
WITHIN = 50
"""Number of instants between two points at which the speed is evaluated."""


def krl_text(plan: Plan, rate: float | None = None) -> str:
    """KUKA KRL program (.src) of PTP points in degrees, for moves to the start and slow checks, at 2 Hz.

    Raises:
        BadLimits: The arm has too many joints, or a joint has no velocity limit.
    """
    states = points(plan, rate or KRL_RATE)
    percent = _percent(plan, states.time)
    scale = np.array([180.0 / np.pi if unit == "rad" else 1000.0 for unit in plan.units])
    name = krl_name(plan.robot)
    lines = [
        f"&COMMENT {name}: points of a motion planned by exidyn",
        f"DEF {name}( )",
        *_krl_remarks(plan),
        "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM( )",
        "INTERRUPT ON 3",
        "BAS(#INITMOV, 0)",
        "BAS(#ACC_PTP, 50)",
        "$APO.CPTP=50",
        "BAS(#VEL_PTP, 10)",
        f"PTP {_axes(scale * states.position[0])}",
    ]
    before = None
    for row in range(1, len(states.time)):
        speed = int(percent[row - 1])
        if speed != before:
            lines.append(f"BAS(#VEL_PTP, {speed})")
            before = speed
        blended = " C_PTP" if row < len(states.time) - 1 else ""
        lines.append(f"PTP {_axes(scale * states.position[row])}{blended}")
    return "\n".join([*lines, "END"]) + "\n"


def _krl_remarks(plan: Plan) -> list[str]:
    names = ", ".join(f"{axis} {joint}" for axis, joint in zip(KRL_AXES, plan.joints, strict=False))
    return [
        ";The controller times these points itself: this is no identification motion.",
        ";Use it to move to the start and to check slowly where the arm goes. The motion itself is sent",
        ";through RSI, cycle by cycle. Between points, and where it blends them, the arm does not follow",
        ";the planned path, and that path is not checked for collisions. Begin with a low override.",
        krl_comment(f"Axes: {names}"),
        ";Degrees (mm for a prismatic joint), with signs and zeros of the robot's description:",
        ";compare a few points with the pendant in T1 before anything moves fast.",
        ";Speeds in percent of the description's velocity limits.",
    ]


def _percent(plan: Plan, times: np.ndarray) -> np.ndarray:
    """Speed of the fastest joint between points in whole percent of its limit, shape (points - 1,)."""
    if plan.trajectory.dof > len(KRL_AXES):
        axes = ", ".join(KRL_AXES)
        raise BadLimits(f"KRL: {plan.trajectory.dof} joints; a KUKA controller has the axes {axes}")
    limited = np.isfinite(plan.limits.velocity) & np.isfinite(plan.limits.velocity_lower)
    for joint in np.flatnonzero(~limited):
        raise BadLimits(
            f"KRL: {plan.joints[joint]} has no velocity limit, so its speed cannot be given in percent. "
            "Set limits.velocity in the robot file and plan again"
        )
    share = np.linspace(0.0, 1.0, WITHIN)
    dense = times[:-1, None] + np.diff(times)[:, None] * share
    velocity = plan.trajectory.at(dense.ravel()).velocity
    used = np.maximum(velocity / plan.limits.velocity, velocity / plan.limits.velocity_lower)
    fastest = np.max(used.reshape(len(dense), -1), axis=1)
    return np.clip(np.ceil(100.0 * fastest), 1, 100)


def _axes(values: np.ndarray) -> str:
    pairs = zip(KRL_AXES, values, strict=False)
    return "{" + ", ".join(f"{axis} {fixed(value, 4)}" for axis, value in pairs) + "}"


ROS_RATE = 50.0
"""Rate of points [Hz]: a controller that interpolates by quintic splines reproduces the motion within a
thousandth, and an editor can open the file of a minute."""
DIGITS = 9
"""Number of decimals: a nanoradian, far below the resolution of any encoder."""

Export = Callable[[Plan, float | None], str]


def csv_text(plan: Plan, rate: float | None = None) -> str:
    """Table of time [s], positions q, velocities v, accelerations a at every sampling period, in SI units."""
    states = points(plan, rate or 1.0 / plan.tick, end=False)
    joints = range(1, plan.trajectory.dof + 1)
    head = ["t", *(f"{letter}{joint}" for letter in "qva" for joint in joints)]
    columns = [states.time[:, None], states.position, states.velocity, states.acceleration]
    rows = [",".join(map(repr, row)) for row in np.concatenate(columns, axis=1).tolist()]
    return "\n".join([",".join(head), *rows]) + "\n"


def ros_text(plan: Plan, rate: float | None = None) -> str:
    """ROS 2 trajectory_msgs/JointTrajectory as YAML for `ros2 topic pub`; 50 points per second."""
    states = points(plan, rate or ROS_RATE)
    lines = [
        hash_comment(f"{plan.robot}, {plan.trajectory.duration:.9g} s, planned by exidyn. To send it once:"),
        '# ros2 topic pub --once TOPIC trajectory_msgs/msg/JointTrajectory "$(cat THIS_FILE)"',
        *_ros_remarks(states),
        'header: {stamp: {sec: 0, nanosec: 0}, frame_id: ""}',
        f"joint_names: [{', '.join(map(double_quoted, plan.joints))}]",
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
    """Remarks on a start or end in motion, which a controller may refuse."""
    ends = ((0, "starts", "bring the arm there at that speed"), (-1, "ends", "configure it to allow that"))
    return [
        f"# It {place} in motion, which a joint_trajectory_controller may refuse: {action}."
        for row, place, action in ends
        if np.any(np.abs(states.velocity[row]) > 10.0**-DIGITS)
    ]


def _numbers(values: np.ndarray) -> str:
    return f"[{', '.join(fixed(value, DIGITS) for value in values)}]"


EXPORTS: dict[str, Export] = {"csv": csv_text, "ros": ros_text, "krl": krl_text}
"""Function from a plan and a rate of points [Hz] to the text, by format; None is the default rate."""
