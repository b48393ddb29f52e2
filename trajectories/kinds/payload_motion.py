"""Motions that identify the payload on the flange, within limits that hold for any payload up to a mass.

The search minimizes the mean relative standard deviation of the payload's ten parameters while friction and
offsets are unknown and the arm is known (D_s-optimality). Its torque bound has the arm without payload and
with the heaviest one at six places. Afterwards the torque is bounded for all payloads at once: it is linear
in mass, center and inertia, so that its extremes are at no mass or at the largest one. If that exceeds a
limit, the motion is planned again with more margin.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.rigid_regressor import INERTIAL, body_regressor
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Payload, Prior, known_parameters
from exidyn.identification.model import Model

from ..errors import BadLimits, Infeasible, in_words_of
from ..limits.usable_limits import Margins, usable
from ..planning.goals import learned, nominal_noise
from ..planning.planner import plan
from ..planning.torque_room import torque_spread
from ..planning.wishes import Wishes, rows_of
from ..plans.plan import Plan
from ..search.criteria import Focus
from ..search.experiment import Experiment
from ..search.goals import Identify
from ..search.torque_bound import TorqueBound
from ..trajectory import Trajectory
from .static_poses import static_poses

TOOL = "tool"
POSES = 6
"""Number of poses: gravity of a payload has four parameters and each pose shows at least two of them; six
leave two for a check."""
DWELL = 0.5
"""Rest at each visit of a pose [s]: currents need 0.1 s to settle."""
LEADS = 4.0
"""Time that rests and leads take of the duration [s]."""
GYRATION = 0.5
"""Largest radius of gyration of a payload over the largest distance of its center from the flange [-]."""
ROUNDS = 3
"""Number of plans that are tried, each with the margin that the last one lacked."""
SPACING = 0.01
"""Sampling period for the torque [s]: at 3 rad/s a joint moves by 0.03 rad, and its torque changes little."""


@dataclass(frozen=True)
class AnyPayload:
    """All payloads that a motion must allow.

    Attributes:
        mass: Largest mass [kg].
        reach: Largest distance of the center of mass from the flange [m].
    """

    mass: float
    reach: float

    def __post_init__(self) -> None:
        for name, value, unit in (("mass", self.mass, "kg"), ("reach", self.reach, "m")):
            if not 0.0 < value < np.inf:
                raise BadLimits(
                    f"largest {name} of the payload: {value:g} {unit}; it must be above 0 and finite"
                )

    def bodies(self) -> list[tuple[tuple[str, float], ...]]:
        """The heaviest payload with its center at the reach along each half axis of the flange."""
        moment = self.mass * (GYRATION * self.reach) ** 2
        inertia = (moment, 0.0, 0.0, moment, 0.0, moment)
        centers = self.reach * np.concatenate([np.eye(3), -np.eye(3)])
        return [known_parameters(self.mass, tuple(center), inertia) for center in centers]

    def largest_torque(self, empty: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Bound of the absolute torque for any of the payloads, shape (t, n) [N m].

        Args:
            empty: Torque without payload, shape (t, n) [N m].
            columns: Torque per `INERTIAL` parameter about the flange, shape (t, n, 10).
        """
        mass, moments = columns[:, :, INERTIAL.index("M")], columns[:, :, 6:9]
        away = self.reach * np.linalg.norm(moments, axis=2)
        # About the flange, no element of the inertia exceeds m (reach^2 + gyration^2); each is bounded alone.
        moment = self.reach**2 * (1.0 + GYRATION**2)
        inertia = moment * np.sum(np.abs(columns[:, :, :6]), axis=2)
        loaded = np.abs(empty + self.mass * mass) + self.mass * (away + inertia)
        return np.maximum(np.abs(empty), loaded)


@dataclass(frozen=True, eq=False)
class Weigh(Identify):
    """The goal to identify a payload; torque limits hold for several.

    Attributes:
        loads: Payload of each run whose torque must keep to the limits.
    """

    loads: tuple[str, ...] = ("",)

    @property
    def payloads(self) -> tuple[str, ...]:
        return self.loads


def payload_plan(
    model: Model,
    payloads: AnyPayload,
    wishes: Wishes,
    *,
    poses: bool = False,
    starts: int = 2,
    seed: int = 0,
    seconds: float = 20.0,
    iterations: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Plan:
    """Plan the motion that identifies a payload best.

    Args:
        model: Nominal model of the arm; that of `wishes.fit`, if there is one.
        payloads: Payloads that the motion must allow.
        wishes: Planning options; `seconds` is the duration of the entire motion.
        poses: Whether to rest at poses instead: mass and center only, for arms that must be slow.
        starts: Number of starts of the search.
        seed: Seed of the first start.
        seconds: Duration of the search [s].
        iterations: Iterations of each start, which replace the duration.
        progress: Called with sentences on the progress.

    Raises:
        BadLimits: Limits are missing, or no joint can move within them.
        Infeasible: No motion keeps to all limits with every payload.
    """
    arm = model if wishes.fit is None else learned(wishes.fit)
    margins = wishes.margins
    for _ in range(ROUNDS):
        tried = replace(wishes, margins=margins)
        motion = (
            _poses(arm, tried, seed)
            if poses
            else _searched(arm, payloads, tried, starts, seed, seconds / ROUNDS, iterations, progress)
        )
        share = largest_share(motion.trajectory, arm, payloads, wishes)
        if share <= 1.0:
            details = {**motion.details, "payload": _words(payloads, share)}
            return replace(motion, criterion="" if poses else "focus on payload", details=details)
        if poses:
            break
        progress(f"a payload could need {100 * share:.0f} % of a torque limit: plan again with more margin")
        margins = replace(margins, torque=1.0 - (1.0 - margins.torque) / share)
    raise Infeasible(
        f"a payload of {payloads.mass:g} kg within {payloads.reach:g} m of the flange could need "
        f"{100 * share:.0f} % of a torque limit. Try a smaller --up-to or --reach"
    )


def _words(payloads: AnyPayload, share: float) -> str:
    limit = f"at most {100 * share:.0f} % of a torque limit" if share > 0.0 else "no torque limits are stated"
    return f"any up to {payloads.mass:g} kg, center within {payloads.reach:g} m of the flange: {limit}"


def _searched(
    model: Model,
    payloads: AnyPayload,
    wishes: Wishes,
    starts: int,
    seed: int,
    seconds: float,
    iterations: int | None,
    progress: Callable[[str], None],
) -> Plan:
    """The optimized motion; its period becomes shorter if it would last longer than requested."""
    limits, _ = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    goal = weigh_goal(model, payloads, wishes, limits)
    core = max(wishes.seconds - LEADS, 0.5 * wishes.seconds)
    motion = None
    for period in (wishes.period, core):
        tried = replace(wishes, seconds=core, period=period)
        [motion] = plan(
            model, tried, goal=goal, starts=starts, seed=seed, seconds=0.5 * seconds, iterations=iterations,
            progress=progress,
        )  # fmt: skip
        if motion.trajectory.duration <= wishes.seconds:
            break
    assert motion is not None
    return motion


def weigh_goal(model: Model, payloads: AnyPayload, wishes: Wishes, limits: Limits) -> Weigh:
    """The goal to identify the payload: friction is unknown, the arm is known."""
    friction = tuple(e for e in model.effects if (e.greased or e.guessed) and not e.needs_load)
    sizes = dict(payloads.bodies()[2])
    typical = {f"{name}{TOOL}": Prior(_size(name, payloads, value)) for name, value in sizes.items()}
    unknown = Model(model.robot, (*friction, Payload(TOOL)), typical)
    loaded, names = model, [""]
    for number, body in enumerate(payloads.bodies(), start=1):
        loaded, names = loaded + Payload(f"{TOOL}{number}", body), [*names, f"{TOOL}{number}"]
    experiment = Experiment.of(unknown, (TOOL,), nominal_noise(loaded, limits, names[3]))
    columns = [k for k, name in enumerate(experiment.base.names) if name.removesuffix("R").endswith(TOOL)]
    return Weigh(experiment, Focus(tuple(columns)), rows_of(wishes), loaded, loads=tuple(names))


def _size(name: str, payloads: AnyPayload, value: float) -> float:
    """Size of a parameter of the heaviest payload, which standard deviations are relative to."""
    power = 0 if name == "M" else 1 if name.startswith("M") else 2
    return max(abs(value), payloads.mass * payloads.reach**power)


def _poses(model: Model, wishes: Wishes, seed: int) -> Plan:
    """Rests at poses that distinguish the gravity of a payload."""
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    with in_words_of(model.robot):
        run = static_poses(
            limits, POSES, wishes.tick, dwell=DWELL, seed=seed, clearances=wishes.clearances,
            model=Model(model.robot, (Payload(TOOL),)), start=wishes.start,
        )  # fmt: skip
    return Plan.of(
        run.trajectory, model, margins=vars(wishes.margins), tick=wishes.tick,
        assumed=(*assumed, *run.notes), details={"kind": "poses for a payload"},
    )  # fmt: skip


def largest_share(motion: Trajectory, model: Model, payloads: AnyPayload, wishes: Wishes) -> float:
    """Largest share of a torque limit that any payload and any likely arm needs; 0 without limits.

    Limits are those of the robot without margin.
    """
    limits = model.robot.limits
    limited = np.isfinite(limits.torque)
    if not np.any(limited):
        return 0.0
    inside, _ = usable(model.robot, Margins(), None, None)
    spread = torque_spread(model, inside, ("",), wishes.sure, wishes.fit)
    bound = TorqueBound(model, limits.torque, ("",), spread)
    states = motion.every(SPACING)
    columns = body_regressor(model.robot.kinematics, states.motion(), model.robot.flange)
    torque = payloads.largest_torque(bound.torque(states, ""), columns) + bound.band(states, "")
    return float(np.max(torque[:, limited] / limits.torque[limited]))
