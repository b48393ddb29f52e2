"""Bodies: links and rotors that differ from the model, and a payload that the model lacks.

A body on the flange in every run and a different last link give the same torque: they are one finding, mass
beyond the last joint. A payload only in runs that state none is a separate finding: a link is always there.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.rigid_regressor import INERTIAL
from ...arm.robot import Robot
from ...effects import Payload, RigidBody
from ...effects.rigid_body import body_inertia, inertial_parameters, inertial_priors, is_body
from ...fit.estimators.consistent import of_pseudo_inertia, pseudo_inertia
from ...model import Model
from ...text_table import NORMAL_95
from ..blocks.prediction import Prediction
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven, cached
from ..runs.usable import HELD_OUT
from .parts import on_motors

SIZE = 0.2
"""Expected distance of a body's mass from its frame [m]; evidence depends only on its logarithm."""
PARTS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")
UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)
PROPORTION = (1.0, *(SIZE,) * 3, *(SIZE**2,) * 6)
BEYOND = "mass_beyond"
"""Name of the group of a payload and the last link."""
LIGHTEST = 1e-3
"""Smallest mass error that any link may have [kg]."""


def _links(model: Model) -> Iterator[Candidate]:
    """Links that are heavier, lighter or displaced beyond their tolerance, if the model has bodies."""
    if not any(effect.of_links for effect in model.effects):
        return
    robot, body = model.robot, RigidBody()
    parameters = [parameter.name for parameter in body.parameters(robot)]
    nominal = dict(zip(model.names, model.nominal_values, strict=True))

    @cached
    def regressor(run: Driven) -> np.ndarray:
        return body.regressor(robot, run.motion)

    for link in range(robot.dof):
        names = tuple(f"{part}{link + 1}" for part in PARTS)
        places = [parameters.index(name) for name in names]

        def columns(run: Driven, places: list[int] = places) -> np.ndarray:
            return on_motors(robot, regressor(run)[:, :, places])

        # A link may be lighter, but by no more than it weighs.
        lower = (-max(float(nominal[names[0]]), 0.0), *(-np.inf,) * 9)
        yield Candidate(
            "link_inertia", (link,), columns, names, UNITS, lower, smooth=True, proportion=PROPORTION, led=1,
            expected=_as_heavy(robot.kinematics.inertias[link + 1]), carried=True,
            same_torque=_beyond(model) if link == robot.dof - 1 else None,
        )  # fmt: skip


def _as_heavy(body: pin.Inertia) -> tuple[tuple[float, float], ...]:
    """Prior of a link's parameters: errors as large as the link itself, and at least those of a gram."""
    nominal = inertial_priors(body, 1.0)
    least = LIGHTEST * np.array(PROPORTION)
    return tuple(
        (0.0, max(nominal[part].std, float(smallest))) for part, smallest in zip(PARTS, least, strict=True)
    )


def _payloads(model: Model) -> Iterator[Candidate]:
    """A body on the flange in every run; of its parameters, only the mass must be positive."""
    body, robot = Payload("unknown"), model.robot
    names = [parameter.name for parameter in body.parameters(robot)]
    places = [names.index(f"{part}unknown") for part in PARTS]

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, body.regressor(robot, replace(run.motion, payload="unknown"))[:, :, places])

    linked = any(effect.of_links for effect in model.effects)
    yield Candidate(
        "payload", (), columns, PARTS, UNITS, (0.0, *(-np.inf,) * 9), smooth=True, proportion=PROPORTION,
        led=1, cancels=True, carried=True, same_torque=_beyond(model) if linked else None,
    )  # fmt: skip


def _beyond(model: Model) -> tuple[str, tuple[int, ...]]:
    return BEYOND, (model.robot.dof - 1,)


def _unless_stated(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """A body on the flange only in the runs that state none, if other runs state one."""
    if len({bool(run.motion.payload) for run in runs if run.role != HELD_OUT}) < 2:
        return
    for everywhere in _payloads(model):

        def columns(run: Driven, everywhere: Candidate = everywhere) -> np.ndarray:
            return everywhere.columns(run) * (not run.motion.payload)

        yield replace(everywhere, columns=columns, kind="where none is stated", same_torque=None)


def _center(finding: Finding, known: Mapping[str, Any]) -> dict[str, str]:
    """Center of mass of a body; only its moments if the mass is not distinguishable from zero."""
    words = _center_of(finding, known)
    if finding.ambiguous:
        words["instead"] = "a payload" if finding.joints else "the last link"
    elif finding.kind:
        words["runs"] = "the runs that state none"
    return words


def _center_of(finding: Finding, known: Mapping[str, Any]) -> dict[str, str]:
    if not {"M", "MX", "MY", "MZ"} <= set(known):
        return {}
    mass, values = known["M"], np.array([known[f"M{axis}"].value for axis in "XYZ"])
    shift = "({:.3g}, {:.3g}, {:.3g})".format(*values)
    if not mass.value > NORMAL_95 * mass.std:
        return {"moments": shift, "shift": shift}
    return {"centre": "({:.0f}, {:.0f}, {:.0f})".format(*(1e3 * values / mass.value)), "shift": shift}


def _with_body(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with the body found added to its link, or to the last one."""
    link, body = _on_link(arm.model.robot, finding.joints, finding.numbers)
    pairs = zip(INERTIAL, of_pseudo_inertia(body), strict=True)
    more = {f"{name}{link + 1}": float(value) for name, value in pairs}
    return arm.with_values(more) if set(more) <= set(arm.model.names) else None


def _on_link(robot: Robot, joints: Sequence[int], numbers: Mapping[str, float]) -> tuple[int, np.ndarray]:
    """Link that has a body found, and the body's pseudo-inertia (4, 4) in the frame of that link."""
    ending = str(joints[0] + 1) if joints else ""
    body = pseudo_inertia(np.array([numbers.get(f"{name}{ending}", 0.0) for name in INERTIAL]))
    placement = np.eye(4) if joints else robot.flange.homogeneous
    return joints[0] if joints else robot.dof - 1, placement @ body @ placement.T


def with_found(bodies: pin.Model, robot: Robot, candidate: Candidate, values: np.ndarray) -> pin.Model:
    """Bodies of an arm with that of a finding (p,); unchanged if it finds none, or if it leaves no mass."""
    if candidate.effect not in ("link_inertia", "payload"):
        return bodies
    link, body = _on_link(robot, candidate.joints, dict(zip(candidate.names, values, strict=True)))
    total = inertial_parameters(bodies.inertias[link + 1]) + of_pseudo_inertia(body)
    if is_body(total):
        bodies = bodies.copy()
        bodies.inertias[link + 1] = body_inertia(total)
    return bodies


KINDS = {
    "link_inertia": Kind(
        family="mass",
        sentence="Link {number}[, or {instead},] is not the body that the model has: {M:size} "
        "{M:heavier|lighter}[, first moments off by {shift} kg m]",
        drawn_against=("position", "acceleration"),
        ask=_links,
        derived=_center,
        held=_with_body,
        of_body=True,
        settled_by="a run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "payload": Kind(
        family="mass",
        sentence="The flange carries a payload that the model does not have[ in {runs}][, or {instead} is "
        "heavier by the same amount]: {M}[, its center of mass at {centre} mm in the flange's frame][, but "
        "these runs hardly determine its mass; its first moments are {moments} kg m in the flange's frame]",
        drawn_against=("position", "acceleration"),
        ask=_payloads,
        ask_first=_unless_stated,
        derived=_center,
        held=_with_body,
        of_body=True,
        settled_by="a run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "rotor_inertia": Kind(
        family="mass",
        sentence="{joint} has a rotor inertia {Ia:size} {Ia:larger|smaller} than in the model",
        drawn_against=("acceleration", "velocity"),
        reducible=True,
        settled_by="a swept sine (exidyn excite --kind chirp)",
    ),
}
