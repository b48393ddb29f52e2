"""Metadata of motors with the MIT frame once they have answered."""

from collections.abc import Iterator, Sequence

import numpy as np

from ..driver import Info
from .damiao_registers import TIMEOUT_UNIT
from .damiao_setup import Found
from .mit_frame import T_MOTOR, State, error_text
from .mit_motors import Motor
from .mit_settings import MitSettings


def info_of(
    s: MitSettings,
    motors: Sequence[Motor],
    found: Sequence[Found],
    states: Sequence[State],
    to_current: np.ndarray,
    to_torque: np.ndarray,
) -> Info:
    """All that explains the measurement later, and what to warn about now.

    Args:
        s: Settings.
        motors: In the order of the joints.
        found: Data of each.
        states: First answer of each.
        to_current: Current per what is answered, shape (n,) [A]; NaN where unknown.
        to_torque: Torque, likewise [N m].
    """
    known = {
        "position": True,
        "velocity": True,
        "current": np.isfinite(to_current).any(),
        "torque": np.isfinite(to_torque).any(),
        "temperature": any(np.isfinite(state.temperature) for state in states),
    }
    timeout = round(s.dead_man / TIMEOUT_UNIT)
    return Info(
        cycle=s.cycle,
        clock="host",
        signals=tuple(name for name, is_known in known.items() if is_known),
        dead_man=f"switched off {s.dead_man:g} s after the host's last frame: an arm without "
        f"brakes drops (TIMEOUT {timeout} read back)"
        if all(one.guarded for one in found)
        else "",
        settings=_explained(s, motors, found),
        warnings=(*(text for one in found for text in one.warnings), *_warnings(s, motors, states)),
    )


def _warnings(s: MitSettings, motors: Sequence[Motor], states: Sequence[State]) -> Iterator[str]:
    for motor, state, ampere in zip(motors, states, s.current_range, strict=True):
        if motor.family is T_MOTOR:
            yield (
                f"{motor.name} goes on with its last command if this computer falls silent; and it reports "
                "its state only when commanded with zero gains, so that opening makes it limp"
            )
            if not ampere:
                yield (
                    f"{motor.name}: its answer is read as torque up to {motor.answered.torque:g} N m; "
                    "makers' papers disagree whether it is a current: set current_range to read one"
                )
        if text := error_text(motor.family, state.error):
            yield f"{motor.name} has {text}; it is cleared when the motors are switched on"


def _explained(s: MitSettings, motors: Sequence[Motor], found: Sequence[Found]) -> dict[str, str]:
    explained = {
        "bus": f"{s.interface} {s.channel}, {s.bitrate} bit/s, load {100.0 * s.load:.0f} % at worst",
        "time of a sample": "when the first command was handed to the bus; a motor measures when its own "
        f"arrives, on a wire up to {1e3 * s.apart:.2f} ms after the one before it",
    }
    for joint, (motor, one) in enumerate(zip(motors, found, strict=True)):
        ranges = motor.answered
        what = "current in A" if s.current_range[joint] else "torque in N m"
        explained[motor.name] = ", ".join(
            [
                f"{motor.family.name} {s.model[joint]}, answers with {what}",
                f"steps of {2.0 * ranges.position / 65535:.3g} rad, "
                f"{2.0 * ranges.velocity / 4095:.3g} rad/s and {2.0 * ranges.torque / 4095:.3g}",
                f"kp {motor.kp:g}, kd {motor.kd:g}, sign {s.sign[joint]}, zero {s.zero[joint]:g} rad",
                *one.facts,
            ]
        )
    return explained
