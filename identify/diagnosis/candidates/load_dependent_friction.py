"""Load-dependent friction: dry friction that grows with what the gear transmits."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects import Effect, LoadDependentFriction, Shape
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts.gears import link_size
from .parts.of_effect import on_each_joint

PRELOADED = 1.0
"""Preload of teeth and bearings that is tried, over a joint's usual load [-]; none is tried too."""
MOST = 3.0
"""Largest preload, over that load [-]: friction beyond it grows with the square of any load that comes."""


def pressed(model: Model) -> Iterator[Candidate]:
    """On each joint, teeth and bearings that are preloaded and such that are not."""
    robot, loads = model.robot, np.maximum(link_size(model)[1], 0.0)

    def with_preload(candidate: Candidate, effect: Effect) -> Candidate:
        assert isinstance(effect, LoadDependentFriction)
        place = candidate.joints[0]
        bounds = {"preload": Shape(robot.unit(place, "N m"), 0.0, MOST * float(loads[place]))}
        return replace(candidate, shape={**candidate.shape, "preload": effect.preload}, bounds=bounds)

    for one in on_each_joint(model, "load_dependent_friction", KIND, with_preload):
        yield one
        assert one.reshaped is not None
        if loads[one.joints[0]] > 0.0:
            yield one.reshaped({"preload": PRELOADED * float(loads[one.joints[0]])})


KIND = Kind(
    sentence="{joint} has load-dependent friction: Coulomb friction grows by {mu} {effort} per {effort} "
    "that the gear transmits[, where that is far above a preload of {preload}]",
    drawn_against=("size of the load", "velocity"),
    ask=pressed,
    mistaken_for=("torque_ripple", "nonlinear_viscous_friction", "drive_gain_saturation"),
    settled_by="a run with a body of known mass on the flange",
)
