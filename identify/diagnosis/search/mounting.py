"""Mounting: a base that stands far from how the model has it, as on a wall or a ceiling.

A base that leans by a degree or two adds torque in proportion; one that leans far turns gravity, which
changes the torque of every link by its own mass. So the rows are formed once for gravity along each axis, of
which every direction is a sum, and the direction with which the blocks predict one another best is looked
for. What was found is the torque by which gravity of that direction differs from the model's, there whole.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from scipy import optimize
from scipy.spatial.transform import Rotation

from ...model import Model
from ..blocks.blocks import period
from ..blocks.prediction import Prediction
from ..candidates.base_tilt import LEANING
from ..candidates.parts.gravity import gravity_columns
from ..candidates.parts.motors import on_motors
from ..questions.block_answer import Answer
from ..questions.candidate import UNNAMED, Candidate, Thinned
from ..questions.candidate_fit import STRANGE
from ..questions.comparison import colouring
from ..questions.question import ask
from ..runs.driven import Driven, gear_torque
from ..runs.rows import Rows, model_rows
from .problem import Asked, Problem
from .selected import CERTAIN_ODDS

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


def mounted_otherwise(problem: Problem) -> Asked:
    """A base that leans far, if the blocks allow it; nothing otherwise."""
    rough = _rough(problem, problem.prediction([]))
    if rough is None:
        return []
    fields = _Fields.of(problem)
    starts = [rough, *np.eye(3), *-np.eye(3)]
    start = max(starts, key=fields.log_probability)
    lean, std = _refined(fields, start)
    direction = _turned(start, lean)
    if _angle(direction, fields.nominal) < FAR:
        return []
    values = fields.prediction(direction).values[: len(problem.model.names)]
    candidate = _candidate(problem.model, direction, problem.model.nominal_values + values, std)
    return [(candidate, Thinned.of(candidate, problem.runs))]


def _rough(problem: Problem, prediction: Prediction) -> np.ndarray | None:
    """Direction of gravity by the torque of the nominal bodies along three axes; None where it is near."""
    model = problem.model

    def columns(run: Driven) -> np.ndarray:
        return gravity_columns(model, run, (0, 1, 2))

    names, free = ("x", "y", "z"), (-np.inf,) * 3
    candidate = Candidate(
        "base_tilt", (), columns, names, ("1",) * 3, free, smooth=True, expected=((0.0, 1.0),) * 3
    )
    answers: Sequence[Answer] = ask(prediction, [(candidate, Thinned.of(candidate, problem.runs))])
    found = [one for one in answers if colouring(prediction, one).gain > CERTAIN_ODDS]
    nominal = _unit(model.robot.gravity)
    if not found or not np.any(model.robot.gravity):
        return None
    direction = _unit(nominal + found[0].values)
    return direction if _angle(direction, nominal) > 0.5 * FAR else None


@dataclass(frozen=True, eq=False)
class _Fields:
    """Rows by the direction of gravity.

    Attributes:
        problem: Whose rows they are.
        still: Columns (r, n, p) and difference (r, n) without gravity.
        along: What gravity along each axis of the base adds to both.
        independent: Independent rows over all rows by which directions are compared, shape (n,).
    """

    problem: Problem
    still: tuple[np.ndarray, np.ndarray]
    along: list[tuple[np.ndarray, np.ndarray]]
    independent: np.ndarray

    @classmethod
    def of(cls, problem: Problem) -> "_Fields":
        """Four sets of rows."""
        size = float(np.linalg.norm(problem.model.robot.gravity))
        every = [
            model_rows(_under(problem.model, size * axis), problem.runs) for axis in (np.zeros(3), *np.eye(3))
        ]
        still = every[0].columns, every[0].difference
        along = [(one.columns - still[0], one.difference - still[1]) for one in every[1:]]
        return cls(problem, still, along, problem.prediction([]).weighting.independent)

    @property
    def nominal(self) -> np.ndarray:
        """Direction of the model's gravity."""
        return _unit(self.problem.model.robot.gravity)

    def prediction(self, direction: np.ndarray) -> Prediction:
        """Of all blocks under gravity of that direction, shape (3,)."""
        columns, difference = (
            own + sum(share * more[place] for share, more in zip(direction, self.along, strict=True))
            for place, own in enumerate(self.still)
        )
        rows: Rows = self.problem.rows
        own = np.concatenate([columns, rows.columns[:, :, columns.shape[2] :]], axis=2)
        rows = replace(rows, columns=own, difference=difference)
        return Prediction.of(rows, self.problem.blocks, 1.0 / period(self.problem.runs[0]))

    def log_probability(self, direction: np.ndarray) -> float:
        """Of all blocks, each predicted by the others."""
        now = self.prediction(direction)
        return float(now.log_probability(now.errors, self.independent).sum())


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


def _candidate(model: Model, direction: np.ndarray, values: np.ndarray, std: float) -> Candidate:
    """The torque of gravity in that direction less that of the model's, by parameters (p,)."""
    turned = _under(model, float(np.linalg.norm(model.robot.gravity)) * direction)

    def columns(run: Driven) -> np.ndarray:
        motion = run.motion
        more = gear_torque(turned, motion, values) - gear_torque(model, motion, values)
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
