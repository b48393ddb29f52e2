"""Drives and their current sensors: gain, saturation, clipping, offset, cross-talk, and a supply that sags.

Saturation: where magnets bias the iron, a motor takes more current from a knee on: beyond it every further
newton metre takes up to 1 + `loss` times the current. Where nothing biases it, the gain is the same for
either sign of the current, so that it falls with the square of the torque x over a ceiling, which no current
exceeds: current over torque is 1 + `loss` x² / (1 - x²).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Shape
from ...measurements import CurrentClipping, DriveGainSaturation
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..findings.quantities import Formatted
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts import RARE, by_another, on_joint, require_current

KNEES = (0.3, 0.5, 0.7)
"""Torque over the largest of all runs from which on a motor gives less per ampere [-]."""
WIDTHS = (0.2, 2.0)
"""Torque beyond the knee, over the largest, at which three quarters of that loss are there [-]: soon, or
beyond what was run."""
CEILINGS = (1.1, 1.5)
"""Torque over the largest of all runs that no current exceeds [-]: near what was run, or beyond it, where the
current lost grows with the cube of the torque."""
SHAPES = ("knee", "width", "ceiling")
"""Numbers of a drive's saturation that are torques over the largest of all runs."""
CLIPS = (0.6, 0.8, 0.9, 0.97)
"""Torque over the largest of all runs at which a current ends [-]."""
ENDS = 0.15
"""By how much that which lies beyond may be more or less than all that is missing [-]: the torque is known so
well."""

Excess = Callable[[np.ndarray], np.ndarray]
"""Current that is lost at a torque, both over those of the largest torque and not below zero [-]."""


def _gains(model: Model) -> Iterator[Candidate]:
    """Each drive whose torque per ampere is another than its tolerance allows."""
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            require_current(run)
            return on_joint(run, joint, -run.torque[:, joint])

        yield Candidate(
            "drive_gain", (joint,), columns, ("share",), ("1",), (-np.inf,), rows=(joint,),
            reported_as=_of_gain, loaded=True, reloads=True,
        )  # fmt: skip


def _of_gain(lacking: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By what share a gain is greater, where a share of the torque is lacking."""
    return lacking / (1.0 - lacking), std / (1.0 - lacking) ** 2


def _with_gain(arm: Arm, finding: Hypothesis) -> Arm:
    share = np.zeros(len(arm.gain))
    share[list(finding.joints)] = finding.parameters["share"].value
    return replace(arm, gain=arm.gain * (1.0 + share))


def saturations(model: Model) -> Iterator[Candidate]:
    """Each drive, from a knee on and below a ceiling."""
    for joint in range(model.robot.dof):
        for knee in KNEES:
            for width in WIDTHS:
                yield _from_a_knee(joint, {"knee": knee, "width": width})
        for ceiling in CEILINGS:
            yield _below_a_ceiling(joint, {"ceiling": ceiling})


def _from_a_knee(joint: int, shape: Mapping[str, float]) -> Candidate:
    def excess(torque: np.ndarray) -> np.ndarray:
        beyond = np.maximum(torque - shape["knee"], 0.0)
        return beyond**2 / (beyond + shape["width"])

    bounds = {"knee": Shape("1", 0.05, 0.9), "width": Shape("1", 0.02, 5.0)}
    return _saturation(joint, excess, shape, bounds, lambda given: _from_a_knee(joint, given))


def _below_a_ceiling(joint: int, shape: Mapping[str, float]) -> Candidate:
    def excess(torque: np.ndarray) -> np.ndarray:
        square = (torque / shape["ceiling"]) ** 2
        return torque * square / (1.0 - square)

    bounds = {"ceiling": Shape("1", 1.03, 4.0)}
    return _saturation(joint, excess, shape, bounds, lambda given: _below_a_ceiling(joint, given))


def _saturation(
    joint: int,
    excess: Excess,
    shape: Mapping[str, float],
    bounds: Mapping[str, Shape],
    reshaped: Callable[[Mapping[str, float]], Candidate],
) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        require_current(run)
        most = max(float(run.most[joint]), 1e-12)
        torque = run.torque[:, joint] / most
        return on_joint(run, joint, most * np.sign(torque) * excess(np.abs(torque)))

    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("loss",), ("1",), (0.0,), dict(shape), bounds, reshaped,
        rows=(joint,), loaded=True,
    )  # fmt: skip


def _saturated(arm: Arm, finding: Hypothesis) -> Arm | None:
    """A drive that saturates; its shape is over the largest torque of the runs."""
    known, [joint] = finding.parameters, finding.joints
    if arm.peak is None:
        return None
    torque = {name: known[name].value * float(arm.peak[joint]) for name in SHAPES if name in known}
    name = arm.model.robot.joints[joint]
    return arm.with_measurement(DriveGainSaturation(name, known["loss"].value, **torque))


def _clips(model: Model) -> Iterator[Candidate]:
    """Each drive's recorded current, which ends while the torque goes on."""
    for joint in range(model.robot.dof):
        for level in CLIPS:
            yield _clip(joint, level)


def _clip(joint: int, level: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        torque = run.torque[:, joint]
        beyond = np.maximum(np.abs(torque) - level * run.most[joint], 0.0)
        return on_joint(run, joint, -np.sign(torque) * beyond)

    return Candidate(
        "current_clipping", (joint,), columns, ("slope",), ("1",), (0.0,), {"level": level},
        {"level": Shape("1", 0.3, 0.999)}, lambda given: _clip(joint, given["level"]), rows=(joint,),
        expected=((1.0, ENDS),), loaded=True, reloads=True,
    )  # fmt: skip


def _clipped(arm: Arm, finding: Hypothesis) -> Arm | None:
    """A current sensor that ends at a share of the largest torque of the runs."""
    [joint] = finding.joints
    if arm.peak is None:
        return None
    limit = finding.parameters["level"].value * float(arm.peak[joint] / abs(arm.gain[joint]))
    return arm.with_measurement(CurrentClipping(limit, (arm.model.robot.joints[joint],)))


def _crosstalks(model: Model) -> Iterator[Candidate]:
    """Each current sensor that also reads another joint's current."""
    return by_another(model, "current_crosstalk", lambda run, joint, other: run.torque[:, other], ("leak",))


def _sags(model: Model) -> Iterator[Candidate]:
    """A voltage that gives way, so that all drives need more current while the arm draws power."""

    def columns(run: Driven) -> np.ndarray:
        power = np.sum(np.maximum(run.torque * run.motion.velocity, 0.0), axis=1)
        return (run.torque * power[:, None])[:, :, None]

    yield Candidate("supply_sag", (), columns, ("sag",), ("1/W",), (0.0,), prior=RARE, listed=False)


def _droop(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """In per cent a kilowatt."""
    if "sag" not in known:
        return {}
    return {"droop": Formatted(1e5 * known["sag"].value, 1e5 * known["sag"].std, "% per kW")}


KINDS = {
    "drive_gain": Kind(
        family="drive",
        sentence="{joint} has a drive that gives {share:size %} {share:more|less} torque per current than "
        "its nominal gain",
        drawn_against=("torque", "load"),
        ask=_gains,
        held=_with_gain,
        mistaken_for=("link_inertia", "encoder_offset"),
        settled_by="a run with a body of known mass on the flange",
    ),
    "drive_gain_saturation": Kind(
        family="drive",
        sentence="{joint} has a drive gain that falls at high torque[, from {knee:%} of the largest torque "
        "on][, below a ceiling of {ceiling:%} of the largest torque]",
        drawn_against=("torque", "velocity"),
        ask=saturations,
        held=_saturated,
        sensor=True,
        mistaken_for=("current_clipping", "nonlinear_viscous_friction"),
        settled_by="a faster run with a body of known mass on the flange",
    ),
    "current_clipping": Kind(
        family="drive",
        sentence="{joint} has a recorded current that is clipped[ at {level:%} of its largest torque] while "
        "the torque goes on rising",
        drawn_against=("torque", "time"),
        ask=_clips,
        held=_clipped,
        sensor=True,
        mistaken_for=("drive_gain_saturation",),
        settled_by="a run at half the speed, in which no current reaches its end",
    ),
    "current_offset": Kind(
        sentence="{joint} has a constant offset of {Off}",
        drawn_against=("position", "velocity"),
        mistaken_for=("friction_asymmetry", "joint_spring"),
        settled_by="rests at poses reached from both sides (exidyn excite --kind poses)",
    ),
    "current_crosstalk": Kind(
        family="other joints",
        sentence="{joint} reads {leak:size %} of the current of joint {other_joint:bare} as well",
        drawn_against=("time", "torque"),
        ask=_crosstalks,
    ),
    "supply_sag": Kind(
        family="drive",
        sentence="The supply voltage sags: all drives need more current the more power the arm draws[, by "
        "{droop}]",
        drawn_against=("torque", "speed"),
        ask=_sags,
        derived=_droop,
    ),
}
"""Name -> what is known of each."""
