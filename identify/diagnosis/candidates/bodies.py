"""Bodies: links and rotors that are other than in the model, and a payload of which it does not know.

A body on the flange of every run and another last link have the same torque: they are one finding, mass
beyond the last joint. A payload that is only in runs without a stated one is another: a link stays there.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.rigid_regressor import INERTIAL
from ...effects import Payload, RigidBody
from ...effects.rigid_body import inertial_priors
from ...fit.estimators.consistent import of_pseudo_inertia, pseudo_inertia
from ...model import Model
from ...text_table import NORMAL_95
from ..blocks.prediction import Prediction
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.kept import kept
from ..runs.usable import HELD_OUT
from .parts import on_motors

SIZE = 0.2
"""How far from its frame the mass of a body is expected to be [m]; evidence depends on its logarithm."""
PARTS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")
UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)
PROPORTION = (1.0, *(SIZE,) * 3, *(SIZE**2,) * 6)
BEYOND = "mass_beyond"
"""What a payload and the last link are together."""
LIGHTEST = 1e-3
"""Mass by which any link may be off [kg]."""


def _links(model: Model) -> Iterator[Candidate]:
    """Each link that is heavier, lighter or elsewhere than its tolerance allows, if the model has bodies."""
    if not any(effect.of_links for effect in model.effects):
        return
    robot, body = model.robot, RigidBody()
    own = [parameter.name for parameter in body.parameters(robot)]
    nominal = dict(zip(model.names, model.nominal_values, strict=True))

    @kept
    def regressor(run: Driven) -> np.ndarray:
        return body.regressor(robot, run.motion)

    for link in range(robot.dof):
        names = tuple(f"{part}{link + 1}" for part in PARTS)
        places = [own.index(name) for name in names]

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
    """How far a link's parameters may be off: about as much as it has, and never less than a gram's worth."""
    nominal = inertial_priors(body, 1.0)
    least = LIGHTEST * np.array(PROPORTION)
    return tuple((0.0, max(nominal[part].std, float(own))) for part, own in zip(PARTS, least, strict=True))


def _payloads(model: Model) -> Iterator[Candidate]:
    """A body on the flange in every run, of which only its mass has a sign."""
    body, robot = Payload("unknown"), model.robot
    names = [parameter.name for parameter in body.parameters(robot)]
    kept = [names.index(f"{part}unknown") for part in PARTS]

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, body.regressor(robot, replace(run.motion, payload="unknown"))[:, :, kept])

    linked = any(effect.of_links for effect in model.effects)
    yield Candidate(
        "payload", (), columns, PARTS, UNITS, (0.0, *(-np.inf,) * 9), smooth=True, proportion=PROPORTION,
        led=1, cancels=True, carried=True, same_torque=_beyond(model) if linked else None,
    )  # fmt: skip


def _beyond(model: Model) -> tuple[str, tuple[int, ...]]:
    return BEYOND, (model.robot.dof - 1,)


def _unless_stated(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """A body on the flange of those runs alone that state none, where others state one."""
    if len({bool(run.motion.payload) for run in runs if run.role != HELD_OUT}) < 2:
        return
    for everywhere in _payloads(model):

        def columns(run: Driven, everywhere: Candidate = everywhere) -> np.ndarray:
            return everywhere.columns(run) * (not run.motion.payload)

        yield replace(everywhere, columns=columns, kind="where none is stated", same_torque=None)


def _centre(finding: Finding, known: Mapping[str, Any]) -> dict[str, str]:
    """Where a body has its mass; only its moments where the mass itself is not distinguished from zero."""
    found = _centre_of(finding, known)
    if finding.ambiguous:
        found["instead"] = "a payload" if finding.joints else "the last link"
    elif finding.kind:
        found["runs"] = "the runs that state none"
    return found


def _centre_of(finding: Finding, known: Mapping[str, Any]) -> dict[str, str]:
    if not {"M", "MX", "MY", "MZ"} <= set(known):
        return {}
    mass, values = known["M"], np.array([known[f"M{axis}"].value for axis in "XYZ"])
    shift = "({:.3g}, {:.3g}, {:.3g})".format(*values)
    if not mass.value > NORMAL_95 * mass.std:
        return {"moments": shift, "shift": shift}
    return {"centre": "({:.0f}, {:.0f}, {:.0f})".format(*(1e3 * values / mass.value)), "shift": shift}


def _with_other_link(arm: Arm, finding: Hypothesis) -> Arm | None:
    [link] = finding.joints
    return _heavier(arm, link, _found_body(finding, str(link + 1)))


def _with_payload(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The last link with the body on it."""
    placement = arm.model.robot.flange.homogeneous
    return _heavier(arm, arm.model.robot.dof - 1, placement @ _found_body(finding) @ placement.T)


def _heavier(arm: Arm, link: int, body: np.ndarray) -> Arm | None:
    """The arm whose link has a further body, given by its pseudo-inertia (4, 4) in the link's frame."""
    pairs = zip(INERTIAL, of_pseudo_inertia(body), strict=True)
    more = {f"{name}{link + 1}": float(value) for name, value in pairs}
    return arm.with_values(more) if set(more) <= set(arm.model.names) else None


def _found_body(finding: Hypothesis, ending: str = "") -> np.ndarray:
    """Pseudo-inertia (4, 4) of a finding's parameters whose names end so; what is not given is zero."""
    known = {name: one.value for name, one in finding.parameters.items()}
    return pseudo_inertia(np.array([known.get(f"{name}{ending}", 0.0) for name in INERTIAL]))


KINDS = {
    "link_inertia": Kind(
        family="mass",
        sentence="Link {number}[, or {instead},] is not the body that the model has: {M:size} "
        "{M:heavier|lighter}[, first moments off by {shift} kg m]",
        drawn_against=("position", "acceleration"),
        ask=_links,
        derived=_centre,
        held=_with_other_link,
        of_body=True,
        mistaken_for=("payload", "spring_balancer", "drive_gain"),
        settled_by="a run with a body of known mass on the flange",
    ),
    "payload": Kind(
        family="mass",
        sentence="The flange carries a payload that the model does not have[ in {runs}][, or {instead} is "
        "heavier by as much]: {M}[, its center of mass at {centre} mm in the flange's frame][, but "
        "these runs hardly determine its mass; its first moments are {moments} kg m in the flange's frame]",
        drawn_against=("position", "acceleration"),
        ask=_payloads,
        ask_first=_unless_stated,
        derived=_centre,
        held=_with_payload,
        of_body=True,
        mistaken_for=("link_inertia", "drive_gain"),
        settled_by="a run with a body of known mass on the flange",
    ),
    "rotor_inertia": Kind(
        family="mass",
        sentence="{joint} has a rotor inertia {Ia:size} {Ia:larger|smaller} than in the model",
        drawn_against=("acceleration", "velocity"),
        reducible=True,
        mistaken_for=("joint_elasticity", "time_delay"),
    ),
}
"""Name -> what is known of each."""
