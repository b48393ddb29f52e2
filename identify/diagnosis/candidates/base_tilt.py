"""Base tilt: gravity has another direction than in the model.

A base that leans by a degree or two adds torque in proportion. One that is mounted otherwise, as on a wall or
a ceiling, turns gravity, which changes the torque of every link by its own mass. For that, rows are formed
once for gravity along each axis of the base, of which every direction is a sum, and the direction is searched
with which the blocks predict one another best. The hypothesis is the torque by which gravity of that
direction differs from the model's: it is there whole or not at all.
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
from .parts import on_motors

LEANING = 0.02
"""How far a base that was set up level may lean [rad]: a degree."""
FAR = STRANGE * LEANING
"""Angle from which on a base does not lean, but is mounted otherwise [rad]: 5 degrees."""
DIRECTIONS = round(4.0 / LEANING**2)
"""Directions of gravity that are distinguished beforehand, a degree apart."""
WHOLE = 1e-6
"""By how much the torque of turned gravity may be more or less than all of it [-]: not at all."""
EVALUATIONS = 40
"""Directions that are tried from the best start: to a tenth of a degree."""
STEP = 0.05
"""First step of that search [rad]."""
NEARER, FARTHER = 0.02, 0.05
"""Angles from the best direction between which its curvature is taken [rad]; upright itself stands out, since
some moments of the first link do not show there."""
RINGS = tuple(angle * np.eye(2) for angle in (NEARER, FARTHER))


def tilts(model: Model) -> Iterator[Candidate]:
    """A base that leans: gravity has a part along its x and y axes."""

    def columns(run: Driven) -> np.ndarray:
        return _gravity_columns(model, run, (0, 1))

    names, lower = ("tilt_x", "tilt_y"), (-np.inf, -np.inf)
    nominal = ((0.0, LEANING),) * 2
    yield Candidate(
        "base_tilt", (), columns, names, ("rad", "rad"), lower, smooth=True, expected=nominal, carried=True
    )


def mounted_otherwise(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """A base that leans far, where the blocks allow it."""
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


def _gravity_columns(model: Model, run: Driven, axes: Sequence[int]) -> np.ndarray:
    """Torque of the motors by gravity along axes of the base, shape (t, n, a) [N m]; payloads included."""
    size, columns = np.linalg.norm(model.robot.kinematics.gravity.linear), []
    for axis in axes:
        bodies = run.bodies.copy()
        bodies.gravity = pin.Motion(size * np.eye(3)[axis], np.zeros(3))
        data = bodies.createData()
        columns.append([pin.computeGeneralizedGravity(bodies, data, q) for q in run.motion.position])
    return on_motors(model.robot, np.stack([np.array(one) for one in columns], axis=2))


def _rough(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> np.ndarray | None:
    """Direction of gravity by the torque of the nominal bodies along three axes; None where it is near."""

    def columns(run: Driven) -> np.ndarray:
        return _gravity_columns(model, run, (0, 1, 2))

    names, free = ("x", "y", "z"), (-np.inf,) * 3
    candidate = Candidate(
        "base_tilt", (), columns, names, ("1",) * 3, free, smooth=True, expected=((0.0, 1.0),) * 3
    )
    answers = ask(prediction, [(candidate, Thinned.of(candidate, runs))])
    found = [one for one in answers if colouring(prediction, one).gain > CERTAIN_ODDS]
    if not found or not np.any(model.robot.gravity):
        return None
    nominal = _unit(model.robot.gravity)
    direction = _unit(nominal + found[0].values)
    return direction if _angle(direction, nominal) > 0.5 * FAR else None


@dataclass(frozen=True, eq=False)
class _Fields:
    """Rows by the direction of gravity."""

    upright: Prediction  # prediction in the model's own gravity
    still: tuple[np.ndarray, np.ndarray]  # columns (r, n, p) and difference (r, n) without gravity
    along: list[tuple[np.ndarray, np.ndarray]]  # what gravity along each axis of the base adds to both

    @classmethod
    def of(cls, model: Model, upright: Prediction, runs: Sequence[Driven]) -> "_Fields":
        """Four sets of rows."""
        size = float(np.linalg.norm(model.robot.gravity))
        every = [model_rows(_under(model, size * axis), runs) for axis in (np.zeros(3), *np.eye(3))]
        still = every[0].columns, every[0].difference
        along = [(one.columns - still[0], one.difference - still[1]) for one in every[1:]]
        return cls(upright, still, along)

    def predicted(self, direction: np.ndarray) -> Prediction:
        """All blocks under gravity of that direction, shape (3,)."""
        columns, difference = (
            own + sum(share * more[place] for share, more in zip(direction, self.along, strict=True))
            for place, own in enumerate(self.still)
        )
        rows = self.upright.rows
        own = np.concatenate([columns, rows.columns[:, :, columns.shape[2] :]], axis=2)
        rows = replace(rows, columns=own, difference=difference)
        return Prediction.of(rows, self.upright.blocks, self.upright.rate)

    def log_probability(self, direction: np.ndarray) -> float:
        """Log probability of all blocks, with as many independent rows as in the model's own gravity."""
        now = self.predicted(direction)
        return float(now.log_probability(now.errors, self.upright.weighting.independent).sum())


def _refined(fields: _Fields, start: np.ndarray) -> tuple[np.ndarray, float]:
    """Rotation vector (2,) from a direction to the best one, and the deviation of each part [rad]."""

    def loss(lean: np.ndarray) -> float:
        return -fields.log_probability(_turned(start, lean))

    corners = np.array([[0.0, 0.0], [STEP, 0.0], [0.0, STEP]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": corners, "xatol": 1e-4, "fatol": 0.01}
    best = optimize.minimize(loss, np.zeros(2), method="Nelder-Mead", options=options)
    near, far = (np.mean([loss(best.x + sign * turn) for turn in ring for sign in (-1, 1)]) for ring in RINGS)
    curvature = 2.0 * max(float(far - near), 1e-6) / (FARTHER**2 - NEARER**2)
    return best.x, float(1.0 / np.sqrt(curvature))


def _mounted(model: Model, direction: np.ndarray, values: np.ndarray, std: float) -> Candidate:
    """The torque of gravity in that direction less that of the model's, by parameters (p,)."""
    turned = _under(model, float(np.linalg.norm(model.robot.gravity)) * direction)

    def columns(run: Driven) -> np.ndarray:
        more = np.subtract(
            *(model_torque(one, run.motion, values, transmitted=True) for one in (turned, model))
        )
        return on_motors(model.robot, more[:, :, None])

    reported = {f"gravity_{axis}": (float(part), "1") for axis, part in zip("xyz", direction, strict=True)}
    reported["lean"] = _angle(direction, _unit(model.robot.gravity)), "rad"
    return Candidate(
        "base_tilt", (), columns, (UNNAMED,), ("1",), (0.0,), smooth=True, expected=((1.0, WHOLE),),
        reported=reported, known=dict.fromkeys(reported, std), among=DIRECTIONS, carried=True,
    )  # fmt: skip


def _under(model: Model, field: np.ndarray) -> Model:
    """The model in another field of gravity, shape (3,) [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))


def _turned(direction: np.ndarray, lean: np.ndarray) -> np.ndarray:
    """A direction (3,) turned by a rotation vector (2,) at a right angle to it [rad]."""
    least = np.eye(3)[int(np.argmin(np.abs(direction)))]
    one = _unit(np.cross(direction, least))
    axis = lean[0] * one + lean[1] * np.cross(direction, one)
    return np.asarray(Rotation.from_rotvec(axis).apply(direction))


def _angle(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.arccos(np.clip(one @ other, -1.0, 1.0)))


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(float(np.linalg.norm(vector)), 1e-300)


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """By what angle the base leans, where that was not found itself."""
    if "lean" in known or "tilt_x" not in known:
        return {}
    return {"lean": length(known, "tilt_x", "tilt_y")}


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """An arm on which gravity acts otherwise."""
    field, known = arm.model.robot.gravity, {name: one.value for name, one in finding.parameters.items()}
    size = float(np.linalg.norm(field))
    if "tilt_x" in known:
        turned = field + size * np.array([known["tilt_x"], known["tilt_y"], 0.0])
    else:
        turned = size * np.array([known[f"gravity_{axis}"] for axis in "xyz"])
    return replace(arm, model=_under(arm.model, turned))


KINDS = {
    "base_tilt": Kind(
        family="gravity",
        sentence="The base is not level: it leans by {lean:deg}[ (gravity has {tilt_x:deg} along x and "
        "{tilt_y:deg} along y)][ (gravity points along {gravity_x:bare}, {gravity_y:bare}, "
        "{gravity_z:bare} of the base frame)]",
        drawn_against=("position", "load"),
        ask=tilts,
        ask_first=mounted_otherwise,
        derived=_derived,
        held=_held,
        of_body=True,
        mistaken_for=("encoder_offset", "link_inertia"),
        settled_by="the base levelled, or turned by a right angle",
    )
}
