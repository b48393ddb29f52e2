"""Drives and their current sensors: gain, saturation, clipping, offset, crosstalk, and a sagging supply.

Saturation: in iron biased by magnets, a motor needs more current from a knee on: beyond it, each additional
newton meter needs up to 1 + `loss` times the current. In unbiased iron, the gain is the same for both signs
of the current. It then falls with the square of x, the torque over a ceiling that no current exceeds: current
over torque is 1 + `loss` x² / (1 - x²).
"""

from collections.abc import Iterator, Mapping
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
"""Torque from which on the gain falls, over the largest torque of all runs [-]."""
WIDTHS = (0.2, 2.0)
"""Torque beyond the knee at which three quarters of the loss are reached, over the largest torque [-]: near
the knee, or beyond the recorded range."""
CEILINGS = (1.1, 1.5)
"""Ceiling of the torque over the largest torque of all runs [-]: close to it, or so far beyond that the extra
current grows with the cube of the torque."""
SHAPES = {"knee": Shape("1", 0.05, 0.9), "width": Shape("1", 0.02, 5.0), "ceiling": Shape("1", 1.03, 4.0)}
"""Parameters of a drive's saturation, which are torques over the largest torque of all runs."""
CLIPS = (0.6, 0.8, 0.9, 0.97)
"""Torque at which a recorded current is clipped, over the largest torque of all runs [-]."""
LEAK = 0.1
"""Expected share of another joint's current that a sensor reads too [-]; coupled motors share all of it."""
ENDS = 0.15
"""Standard deviation of the clipped share from 1 [-]: the accuracy of the model's torque."""


def _gains(model: Model) -> Iterator[Candidate]:
    """Drives whose torque per ampere differs from nominal by more than the tolerance."""
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            require_current(run)
            return on_joint(run, joint, -run.torque[:, joint])

        yield Candidate(
            "drive_gain", (joint,), columns, ("share",), ("1",), (-np.inf,), rows=(joint,),
            reported_as=_of_gain, loaded=True, reloads=True,
        )  # fmt: skip


def _of_gain(lacking: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative error of a gain, from the share of the torque that is lacking."""
    return lacking / (1.0 - lacking), std / (1.0 - lacking) ** 2


def _with_gain(arm: Arm, finding: Hypothesis) -> Arm:
    share = np.zeros(len(arm.gain))
    share[list(finding.joints)] = finding.parameters["share"].value
    return replace(arm, gain=arm.gain * (1.0 + share))


def saturations(model: Model) -> Iterator[Candidate]:
    """Saturation of each drive, from a knee on or below a ceiling."""
    knees = [{"knee": knee, "width": width} for knee in KNEES for width in WIDTHS]
    for joint in range(model.robot.dof):
        for shape in (*knees, *({"ceiling": ceiling} for ceiling in CEILINGS)):
            yield _saturation(joint, shape)


def _saturation(joint: int, shape: Mapping[str, float]) -> Candidate:
    saturating = DriveGainSaturation("", loss=1.0, **shape)

    def columns(run: Driven) -> np.ndarray:
        require_current(run)
        largest = max(float(run.most[joint]), 1e-12)
        torque = run.torque[:, joint] / largest
        return on_joint(run, joint, largest * np.sign(torque) * saturating.excess(np.abs(torque)))

    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("loss",), ("1",), (0.0,), dict(shape),
        {name: SHAPES[name] for name in shape}, lambda new: _saturation(joint, new), rows=(joint,),
        loaded=True,
    )  # fmt: skip


def _saturated(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with a saturating drive; its shape is relative to the largest torque of the runs."""
    known, [joint] = finding.parameters, finding.joints
    if arm.peak is None:
        return None
    torque = {name: known[name].value * float(arm.peak[joint]) for name in SHAPES if name in known}
    name = arm.model.robot.joints[joint]
    return arm.with_measurement(DriveGainSaturation(name, known["loss"].value, **torque))


def _clips(model: Model) -> Iterator[Candidate]:
    """Recorded currents that are clipped while the torque keeps rising."""
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
        {"level": Shape("1", 0.3, 0.999)}, lambda shape: _clip(joint, shape["level"]), rows=(joint,),
        expected=((1.0, ENDS),), loaded=True, reloads=True,
    )  # fmt: skip


def _clipped(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with a current sensor that clips at a share of the largest torque of the runs."""
    [joint] = finding.joints
    if arm.peak is None:
        return None
    limit = finding.parameters["level"].value * float(arm.peak[joint] / abs(arm.gain[joint]))
    return arm.with_measurement(CurrentClipping(limit, (arm.model.robot.joints[joint],)))


def _crosstalks(model: Model) -> Iterator[Candidate]:
    """Current sensors that also read a small share of another joint's current."""
    leaks = by_another(model, "current_crosstalk", lambda run, joint, other: run.torque[:, other], ("leak",))
    return (replace(candidate, expected=((0.0, LEAK),)) for candidate in leaks)


def _sags(model: Model) -> Iterator[Candidate]:
    """A sagging voltage, so that all drives need more current while the arm draws power."""

    def columns(run: Driven) -> np.ndarray:
        power = np.sum(np.maximum(run.torque * run.motion.velocity, 0.0), axis=1)
        return (run.torque * power[:, None])[:, :, None]

    yield Candidate("supply_sag", (), columns, ("sag",), ("1/W",), (0.0,), prior=RARE, listed=False)


def _droop(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Droop in percent per kilowatt."""
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
        settled_by="a run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "drive_gain_saturation": Kind(
        family="drive",
        sentence="{joint} has a drive gain that falls at high torque[, from {knee:%} of the largest torque "
        "on][, below a ceiling of {ceiling:%} of the largest torque]",
        drawn_against=("torque", "velocity"),
        ask=saturations,
        held=_saturated,
        sensor=True,
        settled_by="a faster run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "current_clipping": Kind(
        family="drive",
        sentence="{joint} has a recorded current that is clipped[ at {level:%} of its largest torque] while "
        "the torque keeps rising",
        drawn_against=("torque", "time"),
        ask=_clips,
        held=_clipped,
        sensor=True,
        settled_by="a run at half the speed, in which no current reaches its end",
    ),
    "current_offset": Kind(
        sentence="{joint} has a constant offset of {Off}",
        drawn_against=("position", "velocity"),
        settled_by="rests at poses reached from both sides (exidyn excite --kind poses)",
    ),
    "current_crosstalk": Kind(
        family="other joints",
        sentence="{joint} reads {leak:size %} of the current of joint {other_joint:bare} as well",
        drawn_against=("time", "torque"),
        ask=_crosstalks,
        settled_by="one joint at a time (exidyn excite --kind single-joint)",
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
