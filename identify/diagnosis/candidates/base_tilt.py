"""Base tilt: gravity has another direction than in the model.

The torque from a base that leans by a degree or two is proportional to the angle. A base with a different
mounting, as on a wall or a ceiling, turns gravity, and the effect depends on the mass of every link. For this
case, rows are computed once for gravity along each axis of the base and combined linearly for any direction.
The direction is searched with which the blocks predict one another best. The hypothesis is the difference in
torque between that direction and the model's: it is there in full or not at all.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
from scipy import optimize
from scipy.spatial.transform import Rotation

from ...model import Model
from ..blocks.prediction import Prediction
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.block_answer import CERTAIN_ODDS, STRANGE
from ..questions.candidate import UNNAMED, Candidate, Thinned
from ..questions.comparison import colouring
from ..questions.question import ask
from ..runs.driven import Driven, model_torque
from ..runs.rows import model_rows
from .kinematics import across
from .parts import on_motors

LEANING = 0.02
"""Expected lean of a base that was set up level [rad]: a degree."""
FAR = STRANGE * LEANING
"""Angle from which on a base counts as mounted differently, not as leaning [rad]: 5 degrees."""
DIRECTIONS = round(4.0 / LEANING**2)
"""Number of directions of gravity that are a priori distinct, a degree apart."""
WHOLE = 1e-6
"""Standard deviation of the coefficient from 1 [-]: turned gravity is there in full."""
EVALUATIONS = 40
"""Directions that are tried from the best start, enough for a tenth of a degree."""
STEP = 0.05
"""First step of that search [rad]."""
NEARER, FARTHER = 0.02, 0.05
"""Angles from the best direction that give its curvature [rad]; the exact vertical is avoided, because some
moments of the first link have no effect there."""
RINGS = tuple(angle * np.eye(2) for angle in (NEARER, FARTHER))


def tilts(model: Model) -> Iterator[Candidate]:
    """A base that leans: gravity has components along its x and y axes."""

    def columns(run: Driven) -> np.ndarray:
        return gravity_columns(model, run, np.linalg.norm(model.robot.gravity) * np.eye(3)[:2])

    names, lower = ("tilt_x", "tilt_y"), (-np.inf, -np.inf)
    nominal = ((0.0, LEANING),) * 2
    yield Candidate(
        "base_tilt", (), columns, names, ("rad", "rad"), lower, smooth=True, expected=nominal, carried=True,
        loaded=True,
    )  # fmt: skip


def mounted_differently(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """A base with a different mounting, if the blocks suggest one."""
    rough = _rough(model, prediction, runs)
    if rough is None:
        return
    fields = _Fields.of(model, prediction, runs)
    start = max([rough, *np.eye(3), *-np.eye(3)], key=fields.log_probability)
    lean, std = _refined(fields, start)
    direction = _turned(start, lean)
    if _angle(direction, _unit(model.robot.gravity)) >= FAR:
        values = fields.predicted(direction).values[: len(model.names)]
        yield _mounted(model, direction, model.nominal_values + values, std)


def gravity_columns(model: Model, run: Driven, fields: np.ndarray) -> np.ndarray:
    """Motor torque in gravity fields (a, 3) [m/s^2], shape (t, n, a) [N m]; of all bodies found so far."""
    columns = []
    for field in fields:
        bodies = run.bodies.copy()
        bodies.gravity = pin.Motion(field, np.zeros(3))
        data = bodies.createData()
        torque = [pin.computeGeneralizedGravity(bodies, data, q).copy() for q in run.motion.position]
        columns.append(np.array(torque))
    return on_motors(model.robot, np.stack(columns, axis=2))


def _rough(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> np.ndarray | None:
    """Direction of gravity from the nominal bodies' torque along three axes; None if near the nominal one."""

    def columns(run: Driven) -> np.ndarray:
        return gravity_columns(model, run, np.linalg.norm(model.robot.gravity) * np.eye(3))

    names, free = ("x", "y", "z"), (-np.inf,) * 3
    candidate = Candidate(
        "base_tilt", (), columns, names, ("1",) * 3, free, smooth=True, expected=((0.0, 1.0),) * 3
    )
    answers = ask(prediction, [(candidate, Thinned.of(candidate, runs))])
    certain = [answer for answer in answers if colouring(prediction, answer).gain > CERTAIN_ODDS]
    if not certain or not np.any(model.robot.gravity):
        return None
    nominal = _unit(model.robot.gravity)
    direction = _unit(nominal + certain[0].values)
    return direction if _angle(direction, nominal) > 0.5 * FAR else None


@dataclass(frozen=True, eq=False)
class _Fields:
    """Rows as a function of the direction of gravity."""

    upright: Prediction  # prediction with the model's gravity
    weightless: tuple[np.ndarray, np.ndarray]  # columns (r, n, p) and difference (r, n) without gravity
    along: list[tuple[np.ndarray, np.ndarray]]  # change of both from gravity along each axis of the base

    @classmethod
    def of(cls, model: Model, upright: Prediction, runs: Sequence[Driven]) -> "_Fields":
        """Compute the rows without gravity and with gravity along each axis."""
        size = float(np.linalg.norm(model.robot.gravity))
        base, *axes = [
            model_rows(under_gravity(model, size * axis), runs) for axis in (np.zeros(3), *np.eye(3))
        ]
        along = [(rows.columns - base.columns, rows.difference - base.difference) for rows in axes]
        return cls(upright, (base.columns, base.difference), along)

    def predicted(self, direction: np.ndarray) -> Prediction:
        """Prediction of all blocks with gravity in a direction (3,)."""
        columns, difference = (
            part + sum(share * change[place] for share, change in zip(direction, self.along, strict=True))
            for place, part in enumerate(self.weightless)
        )
        rows = self.upright.rows
        all_columns = np.concatenate([columns, rows.columns[:, :, columns.shape[2] :]], axis=2)
        rows = replace(rows, parts=(all_columns,), difference=difference)
        return Prediction.of(rows, self.upright.blocks, self.upright.rate)

    def log_probability(self, direction: np.ndarray) -> float:
        """Log probability of all blocks, with as many independent rows as in the model's own gravity."""
        prediction = self.predicted(direction)
        return float(prediction.log_probability(prediction.errors, self.upright.weighting.independent).sum())


def _refined(fields: _Fields, start: np.ndarray) -> tuple[np.ndarray, float]:
    """Rotation vector (2,) from a direction to the best one, and the std of each component [rad]."""

    def loss(lean: np.ndarray) -> float:
        return -fields.log_probability(_turned(start, lean))

    corners = np.array([[0.0, 0.0], [STEP, 0.0], [0.0, STEP]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": corners, "xatol": 1e-4, "fatol": 0.01}
    best = optimize.minimize(loss, np.zeros(2), method="Nelder-Mead", options=options)
    near, far = (np.mean([loss(best.x + sign * turn) for turn in ring for sign in (-1, 1)]) for ring in RINGS)
    curvature = 2.0 * max(float(far - near), 1e-6) / (FARTHER**2 - NEARER**2)
    return best.x, float(1.0 / np.sqrt(curvature))


def _mounted(model: Model, direction: np.ndarray, values: np.ndarray, std: float) -> Candidate:
    """Candidate for gravity in a direction instead of the model's, with parameters (p,)."""
    turned = under_gravity(model, float(np.linalg.norm(model.robot.gravity)) * direction)

    def columns(run: Driven) -> np.ndarray:
        torques = (model_torque(arm, run.motion, values, transmitted=True) for arm in (turned, model))
        return on_motors(model.robot, np.subtract(*torques)[:, :, None])

    reported = {f"gravity_{axis}": (float(part), "1") for axis, part in zip("xyz", direction, strict=True)}
    reported["lean"] = _angle(direction, _unit(model.robot.gravity)), "rad"
    return Candidate(
        "base_tilt", (), columns, (UNNAMED,), ("1",), (0.0,), smooth=True, expected=((1.0, WHOLE),),
        reported=reported, known=dict.fromkeys(reported, std), among=DIRECTIONS, carried=True,
    )  # fmt: skip


def under_gravity(model: Model, field: np.ndarray) -> Model:
    """The model in another gravity field (3,) [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))


def _turned(direction: np.ndarray, lean: np.ndarray) -> np.ndarray:
    """Direction (3,) turned by a rotation vector (2,) perpendicular to it [rad]."""
    first, second = across(direction)
    axis = lean[0] * first + lean[1] * second
    return np.asarray(Rotation.from_rotvec(axis).apply(direction))


def _angle(direction: np.ndarray, other: np.ndarray) -> float:
    return float(np.arccos(np.clip(direction @ other, -1.0, 1.0)))


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(float(np.linalg.norm(vector)), 1e-300)


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Angle by which the base leans, from its components if it is not a parameter itself."""
    if "lean" in known or "tilt_x" not in known:
        return {}
    return {"lean": length(known, "tilt_x", "tilt_y")}


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with gravity in the direction found."""
    field = arm.model.robot.gravity
    known = finding.numbers
    size = float(np.linalg.norm(field))
    if "tilt_x" in known:
        turned = field + size * np.array([known["tilt_x"], known["tilt_y"], 0.0])
    else:
        turned = size * np.array([known[f"gravity_{axis}"] for axis in "xyz"])
    return replace(arm, model=under_gravity(arm.model, turned))


KINDS = {
    "base_tilt": Kind(
        family="gravity",
        sentence="The base is not level: it leans by {lean:deg}[ (gravity has {tilt_x:deg} along x and "
        "{tilt_y:deg} along y)][ (gravity points along {gravity_x:bare}, {gravity_y:bare}, "
        "{gravity_z:bare} of the base frame)]",
        drawn_against=("position", "load"),
        ask=tilts,
        ask_first=mounted_differently,
        derived=_derived,
        held=_held,
        of_body=True,
        settled_by="the base leveled, or turned by a right angle",
    )
}
