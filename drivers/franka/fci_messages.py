"""Messages between driver and process: a byte for the kind, then a record or a text.

The module also describes the state that the controller of an FR3 reports, and why it cannot be commanded.
"""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..samples import word
from .target_stream import JOINTS

ROBOT_MODE = {
    0: "other", 1: "idle", 2: "move", 3: "guiding", 4: "reflex", 5: "user stopped", 6: "error recovery",
}  # fmt: skip
READY_MODES = (1, 2)
"""Robot modes in which the arm can be moved."""
TRY = {
    0: "unlock the joints and activate FCI in Desk",
    3: "release the guiding button, and choose Execution",
    4: "find its cause, then recover it in Desk, or by `recover = true`",
    5: "release the user stop (external activation device)",
    6: "wait, and begin again",
}
"""Robot mode -> what to do."""

ERRORS = (
    "joint_position_limits_violation", "cartesian_position_limits_violation",
    "self_collision_avoidance_violation", "joint_velocity_violation", "cartesian_velocity_violation",
    "force_control_safety_violation", "joint_reflex", "cartesian_reflex",
    "max_goal_pose_deviation_violation", "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation", "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation", "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity", "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent", "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation", "start_elbow_sign_inconsistent",
    "communication_constraints_violation", "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame_flag", "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning", "tau_J_range_violation", "instability_detected",
    "joint_move_in_wrong_direction", "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation", "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading",
)  # fmt: skip
"""Names of errors in the order of libfranka; a state has the number of the first active one, from 1."""
HELP = {
    "joint_reflex": "a torque is beyond the collision threshold: free the arm, or plan a slower motion, or "
    "raise `collision_torque`",
    "cartesian_reflex": "a force at the hand is beyond the collision threshold: free the arm, or raise "
    "`collision_force`",
    "communication_constraints_violation": "20 commands in a row came too late: use a dedicated cable, no "
    "power saving, a real-time kernel",
    "joint_position_limits_violation": "guide it back by hand, and plan within the limits",
    "joint_velocity_violation": "plan a slower motion, or `--speed`",
    "power_limit_violation": "plan a slower motion, or `--speed`",
    "self_collision_avoidance_violation": "plan with the arm's geometry, see docs/trajectories.md",
    "instability_detected": "does the load that is set in Desk match the one on the flange?",
    "tau_J_range_violation": "does the load that is set in Desk match the one on the flange?",
    "joint_move_in_wrong_direction": "the joint was left beyond its limit: guide it back by hand",
}
"""Error -> meaning and what to try."""
BY_COMMANDS = "the commands were not smooth enough for the controller: plan with less jerk"
"""Meaning of errors of the motion generator."""

MODE, ERROR = 0, 1
"""Indices of robot mode and error in the state."""
STATE: Mapping[str, Mapping[int, str]] = {
    "robot_mode": ROBOT_MODE,
    "error": {0: "none", **{number: name for number, name in enumerate(ERRORS, 1)}},
    "success_rate": {},
    **{f"{name}{joint}": {} for name in ("tau_J_d", "theta", "dtheta") for joint in range(1, JOINTS + 1)},
}
"""Recorded parts of the controller's state -> meanings of their codes."""


def error_names(text: str) -> list[str]:
    """Names of errors in a text of libfranka."""
    return [name for name in re.findall(r"\w+", text) if name in ERRORS]


def error_code(text: str) -> int:
    """Number of the first error in a text of libfranka; 0 without an error."""
    names = error_names(text)
    return ERRORS.index(names[0]) + 1 if names else 0


def explained(names: list[str]) -> str:
    """List of errors, and what to try against the first."""
    advice = HELP.get(names[0], BY_COMMANDS if "motion_generator" in names[0] else "see Desk")
    return f"{', '.join(names)}: {advice}"


def mode_of(record: np.void) -> int:
    """Robot mode in a record."""
    return int(record["state"][MODE])


def obstacle(record: np.void) -> str:
    """Why the arm cannot be moved, with what to try; empty if it can be."""
    mode, code = mode_of(record), int(record["state"][ERROR])
    if mode in READY_MODES and not code:
        return ""
    reason = explained([ERRORS[code - 1]]) if code else TRY.get(mode, "see Desk")
    return f"robot mode is {word(ROBOT_MODE, mode)} ({mode}): {reason}"


ASK, FLOW, TARGET, STOP, OFF = b"A", b"F", b"C", b"Q", b"O"
"""Messages to the process: send one state; send all states from now on; a command, seven float64 [rad]; stop
the arm; end the motion at once, whatever the arm does."""
READY, SEEN, FAULT, FATAL = b"R", b"S", b"X", b"E"
"""Messages from the process: connected, with the library's version; a state; why commands are no longer
taken; why the process has ended."""

IDLE, FOLLOWING, STOPPING, ENDED = range(4)
"""Phase of the motion in a record."""

RECORD = np.dtype(
    [
        ("time", "<i8"),  # of the controller [ns]
        ("arrival", "<i8"),  # monotonic clock of this computer [ns]
        ("q", "<f8", JOINTS),
        ("dq", "<f8", JOINTS),
        ("q_d", "<f8", JOINTS),
        ("tau_J", "<f8", JOINTS),
        ("state", "<f8", len(STATE)),
        ("motion", "<i8"),
    ]
)
"""A state of the controller, with the names of libfranka's `RobotState`, in radians and newton meters;
`state` contains the parts in `STATE`."""
VECTORS = ("q", "dq", "q_d", "tau_J")


def target(position: np.ndarray) -> bytes:
    """Encode a command, shape (7,) [rad]."""
    return TARGET + np.asarray(position, "<f8").tobytes()


def read_target(body: bytes) -> np.ndarray:
    """Decode the position of a command, shape (7,) [rad]."""
    return np.frombuffer(body, "<f8", JOINTS)


def record(**fields: Any) -> bytes:
    """Encode a state as a message."""
    state = np.zeros(1, RECORD)
    for name, value in fields.items():
        state[name] = value
    return SEEN + state.tobytes()


def read_record(body: bytes) -> np.void:
    """Decode a state. Raises ValueError for another length."""
    state: np.void = np.frombuffer(body, RECORD)[0]
    return state
