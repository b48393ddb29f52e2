"""The functions of a feedforward as programs: traced once, then written in either language."""

from typing import NamedTuple

from ..dynamics.dynamics import Dynamics
from ..dynamics.program import Language, Lines, written
from ..dynamics.traced import traced_state


class Function(NamedTuple):
    """A function of joint states that returns one number per joint.

    Attributes:
        name: Name of the function in the file.
        arguments: Names of its arguments, each with one number per joint.
        meaning: What it returns, a noun phrase.
        lines: Body of the function.
    """

    name: str
    arguments: tuple[str, ...]
    meaning: str
    lines: Lines


def functions(dynamics: Dynamics, unit: str, language: Language) -> list[Function]:
    """Inverse dynamics, holding torque and friction of an arm, in a language."""
    tape, state = traced_state(dynamics.robot.dof)
    warmth = ("temperature",) if dynamics.needs_temperature else ()
    kinds = (
        ("inverse_dynamics", ("q", "dq", "ddq"), dynamics.torque, "Joint torque of a motion"),
        ("gravity", ("q",), dynamics.gravity_torque, "Joint torque that holds the arm at rest"),
        ("friction", ("q", "dq"), dynamics.friction_torque, "Friction torque as identified, not reduced"),
    )
    return [
        Function(name, arguments + warmth, f"{meaning} [{unit}].", written(tape, torque(state), language))
        for name, arguments, torque, meaning in kinds
    ]
