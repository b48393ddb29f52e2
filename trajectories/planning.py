"""Planning: from a model and what is wished to a plan that a recorder can run."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

import numpy as np
from exidyn.identify.base_parameters import BaseParameters, rich_motion
from exidyn.identify.effects import Belief, Payload
from exidyn.identify.errors import DifferentRobot
from exidyn.identify.fit import Fit
from exidyn.identify.model import Model
from exidyn.identify.robot import Limits

from .clearances.clearance import Clearance
from .errors import BadLimits, NothingToIdentify, UnknownChoice
from .families.fourier import Fourier
from .limits.usable_limits import Margins, usable
from .plans.plan import Plan
from .search.criteria import CRITERIA, Criterion, Focus
from .search.excite import Found, Setting, excite
from .search.goals import Goal, Identify
from .search.information import Experiment
from .search.payload_guess import with_payload
from .search.shrink import inside_kinematics
from .search.torque_bound import TorqueBound
from .search.unknowns import with_drive_gains, with_shapes
from .whole_run import whole_run

NOISE = 0.01
"""Torque noise where none was measured, as a share of each joint's rms torque in a random motion: the
currents of industrial drives, at 500 Hz, scatter by one per cent."""
THERE_AND_BACK = (2.0, 3.0, 4.0)
"""Base periods to try where none is given, in times that the slowest joint takes across its range: there
and back at full speed, at two thirds of it, and at half, so that faster harmonics have room."""
ROWS = 2.0
"""Independent rows a second and hertz of bandwidth (Nyquist)."""
BANDWIDTH = 10.0
"""Up to which torque is compared where no fit says it [Hz]: where filters of identification usually end."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """What is wished of a trajectory.

    Attributes:
        criterion: A name in `CRITERIA`.
        harmonics: Number of harmonics of each joint.
        period: Base period [s]; several are tried unless given.
        seconds: Length of the exciting part; as many periods as fill it [s].
        series: How many trajectories are planned together.
        margins: What is kept off the limits.
        window: Of the controller's corrections around the start pose, as in `usable`.
        start: Pose at which the run begins and ends, shape (n,) [rad]; chosen unless given.
        tick: Cycle of the controller [s].
        rest: At both ends, for the noise of the still arm [s].
        clearances: Collisions and regions.
        shapes: Effects whose shapes count as unknown, by their key.
        payload: What is known of a body that the second run of a pair carries; None for no pair.
        fit: What earlier runs told.
        focus: Names, or beginnings of names, of base parameters that alone matter; "gain" stands for the
            drive gains of a pair.
    """

    criterion: str = "condition"
    harmonics: int = 5
    period: float | None = None
    seconds: float = 40.0
    series: int = 1
    margins: Margins = field(default_factory=Margins)
    window: np.ndarray | None = None
    start: np.ndarray | None = None
    tick: float = 0.002
    rest: float = 1.0
    clearances: Sequence[Clearance] = ()
    shapes: Sequence[str] = ()
    payload: tuple[tuple[str, float], ...] | None = None
    fit: Fit | None = None
    focus: Sequence[str] = ()

    def __post_init__(self) -> None:
        times = {"tick": self.tick, "length": self.seconds, "period": self.period}
        for name, value in times.items():
            if value is not None and not 0.0 < value < np.inf:
                raise BadLimits(f"{name}: {value:g} s; it must be above 0 and finite")
        if not 0.0 <= self.rest < np.inf:
            raise BadLimits(f"rest: {self.rest:g} s; it must be 0 or more")
        for name, count in {"harmonics": self.harmonics, "trajectories": self.series}.items():
            if count < 1:
                raise BadLimits(f"{name}: {count}; there must be at least 1")


def plan(
    model: Model,
    wishes: Wishes,
    *,
    goal: Goal | None = None,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    executor: Executor | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Plan]:
    """The best trajectories for a model, each with rests and leads, checked.

    Args:
        model: What is believed of the arm.
        wishes: What is wanted.
        goal: Another goal than to identify the model, such as to tell two models apart.
        starts: Of the search.
        seed: Of the first start.
        seconds: For the search [s].
        executor: Where the starts run.
        progress: Called with sentences.

    Raises:
        BadLimits: Limits that are not said, or that nothing can move within.
        Infeasible: No motion keeps to all limits.
        NothingToIdentify: The model has no parameter that motion could tell.
        UnknownChoice: A criterion that there is not.
    """
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    goal = goal or identification_goal(model, wishes, limits)
    setting = Setting(
        limits,
        wishes.harmonics,
        periods_of(wishes, limits),
        wishes.clearances,
        wishes.series,
        wishes.tick,
    )
    found = excite(
        goal, setting, starts=starts, seed=seed, seconds=seconds, executor=executor, progress=progress
    )
    return [_plan(model, wishes, goal, found, series, limits, assumed) for series in found.series]


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """To tell the model's parameters, and the drive gains where a pair of runs can."""
    if wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    payloads: tuple[str, ...] = ("",)
    believed = model
    if wishes.payload is not None:
        believed, payloads = with_payload(model, wishes.payload), ("", "L")
    if wishes.fit is not None:
        return _after(wishes.fit, believed, payloads, wishes)
    asked = with_shapes(believed, wishes.shapes)
    asked = with_drive_gains(asked) if wishes.payload is not None else asked
    experiment = Experiment.of(asked, payloads, believed_noise(believed, limits, payloads[-1]))
    criterion: Criterion = CRITERIA[wishes.criterion]
    if wishes.focus:
        criterion = focus(experiment.base, wishes.focus)
    return Identify(experiment, criterion, believed=believed)


def focus(base: BaseParameters, names: Sequence[str]) -> Focus:
    """Criterion for some base parameters; a name stands for all that begin with it.

    Raises:
        UnknownChoice: A name with which none begins.
    """
    for name in names:
        if not any(each.startswith(name) for each in base.names):
            raise UnknownChoice("base parameter", name, base.names)
    return Focus(tuple(k for k, each in enumerate(base.names) if each.startswith(tuple(names))))


def _after(fit: Fit, model: Model, payloads: tuple[str, ...], wishes: Wishes) -> Identify:
    """To add to what a fit knows already, where it knows least.

    Raises:
        DifferentRobot: A fit of another arm.
        NothingToIdentify: A payload or shapes of which the fit knows nothing.
    """
    if fit.model.robot.joints != model.robot.joints:
        raise DifferentRobot(
            f"the fit is of {fit.model.robot.name} (joints {', '.join(fit.model.robot.joints)}), and the "
            f"robot is {model.robot.name} (joints {', '.join(model.robot.joints)}); give the fit of this one"
        )
    bodies = {effect.name for effect in fit.model.effects if isinstance(effect, Payload)}
    if wishes.shapes or not set(payloads) <= {"", *bodies}:
        what = "shapes" if wishes.shapes else "a payload"
        raise NothingToIdentify(f"the fit knows nothing of {what}; plan for {what} without a fit")
    noise = np.maximum(fit.estimate.noise, np.finfo(float).tiny)
    base, told = _told(fit, payloads)
    known = np.linalg.pinv(fit.estimate.covariance[np.ix_(told, told)], hermitian=True)
    experiment = Experiment(learned(fit), base, payloads, noise, known)
    rows = rows_of(wishes, fit.filtering.torque_cutoff)
    criterion: Criterion = CRITERIA["worst" if wishes.criterion == "condition" else wishes.criterion]
    if wishes.focus:
        criterion = focus(base, wishes.focus)
    return Identify(experiment, criterion, rows)


def _told(fit: Fit, payloads: tuple[str, ...]) -> tuple[BaseParameters, np.ndarray]:
    """The base parameters that runs with these payloads move, and their places among those of the fit.

    Those of a body that no run carries stay as unsure as they are, whatever the motion.
    """
    regressors = [fit.model.regressor(rich_motion(fit.model, payload=payload)) for payload in payloads]
    told = np.flatnonzero(np.any(np.concatenate(regressors), axis=(0, 1))[fit.base.kept])
    return replace(fit.base, kept=fit.base.kept[told], regrouping=fit.base.regrouping[told]), told


def learned(fit: Fit) -> Model:
    """The model of a fit, believed as the fit found it: its torque, and sizes, are then the fitted ones."""
    believed, base = fit.model.believed_values, fit.base
    missing = fit.estimate.values - base.regrouping @ believed
    values = dict(zip(np.array(fit.model.names)[base.kept], believed[base.kept] + missing, strict=True))
    stds = dict(zip(values, fit.estimate.std, strict=True))
    stated = {str(name): Belief(float(value), float(stds[name])) for name, value in values.items()}
    return replace(fit.model, stated={**fit.model.stated, **stated})


def rows_of(wishes: Wishes, bandwidth: float | None = None) -> float:
    """Independent rows of all trajectories whose torque is compared up to `bandwidth` [Hz]."""
    return ROWS * (bandwidth or BANDWIDTH) * wishes.seconds * wishes.series


def believed_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Noise of each drive's torque where none was measured, shape (n,) [N m]; see `NOISE`."""
    n, random = model.robot.dof, np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    series = inside_kinematics(Fourier(10.0, middle, *random.normal(size=(2, n, 5))), limits, 0.9)
    motion = model.loaded(series.at(np.linspace(0.0, 10.0, 500)).motion(payload))
    on_motors = model.torque(motion, model.believed_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(n)


def periods_of(wishes: Wishes, limits: Limits) -> tuple[float, ...]:
    """Base periods to try, whole numbers of ticks [s]."""
    across = float(np.max((limits.position_upper - limits.position_lower) / limits.velocity))
    asked = [wishes.period] if wishes.period else [times * across for times in THERE_AND_BACK]
    return tuple(max(round(period / wishes.tick), 1) * wishes.tick for period in asked)


def _plan(
    model: Model,
    wishes: Wishes,
    goal: Goal,
    found: Found,
    series: Fourier,
    limits: Limits,
    assumed: tuple[str, ...],
) -> Plan:
    """One trajectory as a whole run."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads)
    run = whole_run(
        series,
        limits,
        wishes.tick,
        repeats=max(1, int(np.ceil(wishes.seconds / series.period - 1e-9))),
        start=wishes.start,
        rest=wishes.rest,
        clearances=wishes.clearances,
        torques=[bound.of(payload) for payload in goal.payloads],
    )
    return Plan.of(
        run,
        model,
        margins=vars(wishes.margins),
        criterion=_criterion(goal, wishes),
        reached=float(np.exp(found.value)),
        details={"period": series.period, "harmonics": series.harmonics, "goal": goal.words(found.value)},
        seed=found.seed,
        tick=wishes.tick,
        payload_pair=wishes.payload is not None,
        assumed=assumed,
    )


def _criterion(goal: Goal, wishes: Wishes) -> str:
    """What was minimised, in a word or two."""
    if not isinstance(goal, Identify):
        return type(goal).__name__.lower()
    names = {id(criterion): name for name, criterion in CRITERIA.items()}
    return names.get(id(goal.criterion)) or f"focus on {' '.join(wishes.focus)}"
