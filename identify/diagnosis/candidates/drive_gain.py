"""Drive gain: a drive whose torque per ampere is another than its tolerance allows."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.motors import on_joint, require_current


def gains(model: Model) -> Iterator[Candidate]:
    """Each drive in turn."""
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            require_current(run)
            return on_joint(run, joint, -run.torque[:, joint])

        yield Candidate(
            "drive_gain",
            (joint,),
            columns,
            ("share",),
            ("1",),
            (-np.inf,),
            rows=(joint,),
            reported_as=_of_gain,
            loaded=True,
            reloads=True,
        )


def _of_gain(lacking: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By what share a gain is greater, where a share of the torque is lacking."""
    return lacking / (1.0 - lacking), std / (1.0 - lacking) ** 2


def _held(arm: Arm, finding: Finding) -> Arm:
    share = np.zeros(len(arm.gain))
    share[list(finding.joints)] = finding.parameters["share"].value
    return replace(arm, gain=arm.gain * (1.0 + share))


KIND = Kind(
    sentence="{joint} has a drive that gives {share:size %} {share:more|less} torque per current than its "
    "nominal gain",
    drawn_against=("torque", "load"),
    ask=gains,
    held=_held,
    mistaken_for=("link_inertia", "encoder_offset"),
    settled_by="a run with a body of known mass on the flange",
)
