"""Motions that identify the payload on the flange, within limits that hold for any payload up to a mass.

The search minimizes the mean relative standard deviation of the payload's ten parameters while friction and
offsets are unknown and the arm is known (D_s-optimality). Its torque bound has the arm without payload and
with a heavy one. Afterwards the torque is bounded for all payloads at once: it is linear
in mass, center and inertia, so that its extremes are at no mass or at the largest one. If that exceeds a
limit, a slower motion is planned: torque beyond that of creeping along it falls with the square of speed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from exidyn.identification.arm.rigid_regressor import INERTIAL, body_regressor
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Payload, Prior, known_parameters
from exidyn.identification.model import Model

from ..errors import BadLimits, Infeasible, in_words_of
from ..limits.usable_limits import Margins, usable
from ..plans.plan import Plan
from ..search.experiment import Experiment
from ..search.goals import Focus, Identify
from ..search.torque_bound import TorqueBound
from ..trajectory import States, Trajectory
from .goals import learned, nominal_noise, torque_spread
from .planner import plan
from .rests import Workspace
from .static_poses import static_poses
from .wishes import Wishes, beside_periods, periods_of, rows_of

TOOL, HEAVY = "tool", "heavy"
"""Names of the payload to identify, and of one that the torque bound has."""
HEAVIEST = "heaviest"
"""Detail of a plan: largest mass of a payload that the motion allows [kg]."""
POSES = 6
"""Number of poses: gravity of a payload has four parameters and each pose shows at least two of them; six
leave two for a check."""
DWELL = 0.5
"""Rest at each visit of a pose [s]: currents need 0.1 s to settle."""
GYRATION = 0.5
"""Largest radius of gyration of a payload over the largest distance of its center from the flange [-]."""
CALM = 0.5
"""Share of the velocity limits that a motion between poses uses, and its square that of the acceleration."""
DRAWN = 400
"""Number of random poses of which the one with the least torque is the middle of all poses."""
NARROWER = (1.0, 0.5, 0.3)
"""Share of the joints' ranges that the poses use, in each round."""
ROUNDS = 3
"""Number of plans that are tried, each as slow as the last one had to be."""
SPARE = 0.9
"""Speed of the next plan over that at which the last one would need the whole torque limit."""
SLOWEST = 0.3
"""Smallest such speed."""
CREEPING = 1e-6
"""Speed at which gravity and Coulomb friction remain, over that of the motion."""
SPACING = 0.01
"""Sampling period for the torque [s]: at 3 rad/s a joint moves by 0.03 rad, and its torque changes little."""


@dataclass(frozen=True)
class AnyPayload:
    """All payloads that a motion must allow."""

    mass: float  # largest mass [kg]
    reach: float  # largest distance of the center of mass from the flange [m]

    def __post_init__(self) -> None:
        for name, value, unit in (("mass", self.mass, "kg"), ("reach", self.reach, "m")):
            if not 0.0 < value < np.inf:
                raise BadLimits(
                    f"largest {name} of the payload: {value:g} {unit}; it must be above 0 and finite"
                )

    def __str__(self) -> str:
        return f"payload of up to {self.mass:g} kg within {self.reach:g} m of the flange"

    @property
    def heaviest(self) -> tuple[tuple[str, float], ...]:
        """Known parameters of the heaviest payload with its center at the reach along the flange's z axis."""
        moment = self.mass * (GYRATION * self.reach) ** 2
        return known_parameters(self.mass, (0.0, 0.0, self.reach), (moment, 0.0, 0.0, moment, 0.0, moment))

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


@dataclass(frozen=True)
class Need:
    """Torque that any payload and any likely arm needs, as shares of the torque limit of one joint."""

    share: float  # of the motion; 0 without limits
    still: float  # of creeping along it
    joint: str  # the joint with the largest share
    fit_helps: bool  # whether the nominal arm keeps to the limits

    @classmethod
    def of(cls, model: Model, shares: np.ndarray, creeping: np.ndarray) -> "Need":
        """Need from `_shares` of a motion, shape (2, t, n), and from those of creeping, shape (t, n)."""
        if not np.any(np.isfinite(model.robot.limits.torque)):
            return cls(0.0, 0.0, "", False)
        likely, nominal = np.max(shares, axis=1)
        joint = int(np.argmax(likely))
        still = float(np.max(creeping[:, joint]))
        return cls(float(likely[joint]), still, model.robot.joints[joint], bool(np.max(nominal) <= 1.0))

    def __str__(self) -> str:
        return f"{self.joint} could need {100 * self.share:.0f} % of its torque limit"

    def slower(self, margins: Margins) -> Margins:
        """Margins with which the same motion would need less than the limit."""
        speed = SPARE * np.sqrt(max(1.0 - self.still, 0.0) / max(self.share - self.still, 1.0 - self.still))
        speed = float(np.clip(speed, SLOWEST, SPARE))
        return replace(
            margins,
            velocity=1.0 - (1.0 - margins.velocity) * speed,
            acceleration=1.0 - (1.0 - margins.acceleration) * speed**2,
            jerk=1.0 - (1.0 - margins.jerk) * speed**3,
        )


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
    """Plan the motion that identifies a payload best, with the search options of `planner.plan`.

    The wished duration is that of the entire motion. With `poses`, the arm rests at poses instead, for arms
    that must be slow: they show mass and center only.

    Raises:
        BadLimits: Limits are missing, or no joint can move within them.
        Infeasible: No motion keeps to all limits with every payload.
    """
    arm = model if wishes.fit is None else learned(wishes.fit)
    limits, _ = usable(arm.robot, wishes.margins, wishes.window, wishes.start)
    _require(_folded(arm, payloads, wishes, limits, seed)[1], payloads)
    for number in range(ROUNDS):
        if poses:
            motion = _poses(arm, payloads, wishes, NARROWER[number], seed)
        else:
            motion = _searched(
                arm, payloads, wishes, starts=starts, seed=seed, seconds=seconds / ROUNDS,
                iterations=iterations, progress=progress,
            )  # fmt: skip
        need = largest_need(motion.trajectory, arm, payloads, wishes)
        if need.share <= 1.0:
            break
        progress(f"{need}: planning a slower motion")
        wishes = replace(wishes, margins=need.slower(wishes.margins))
    _require(need, payloads)
    used = f"at most {100 * need.share:.0f} % of a torque limit" if need.joint else "no torque limits known"
    words = f"any up to {payloads.mass:g} kg, center within {payloads.reach:g} m of the flange: {used}"
    details = {**motion.details, "payload": words, HEAVIEST: payloads.mass}
    return replace(motion, criterion="" if poses else "focus on payload", details=details)


def _searched(arm: Model, payloads: AnyPayload, wishes: Wishes, **search: Any) -> Plan:
    """The best motion of one period, so that it has low frequencies too, between rests and leads."""
    limits, _ = usable(arm.robot, wishes.margins, wishes.window, wishes.start)
    periods_of(wishes, limits)  # refuses a duration that is too short
    wishes = replace(wishes, period=wishes.period or wishes.seconds - beside_periods(wishes, limits))
    try:
        [motion] = plan(arm, wishes, goal=weigh_goal(arm, payloads, wishes), **search)
    except Infeasible as error:
        raise Infeasible(f"{payloads}: {error}. Or try a smaller --up-to or --reach") from error
    return motion


def weigh_goal(model: Model, payloads: AnyPayload, wishes: Wishes) -> Identify:
    """The goal to identify the payload: friction is unknown, the arm is known.

    The torque of the arm without payload and with a heavy one must keep to the limits.
    """
    friction = tuple(e for e in model.effects if (e.greased or e.guessed) and not e.needs_load)
    typical = {f"{name}{TOOL}": Prior(_size(name, payloads)) for name in INERTIAL}
    unknown = Model(model.robot, (*friction, Payload(TOOL)), typical)
    loaded = model + Payload(HEAVY, payloads.heaviest)
    limits, _ = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    experiment = Experiment.of(unknown, (TOOL,), nominal_noise(loaded, limits, HEAVY))
    columns = [k for k, name in enumerate(experiment.base.names) if name.removesuffix("R").endswith(TOOL)]
    return Identify(experiment, Focus(tuple(columns)), rows_of(wishes), loaded, ("", HEAVY))


def _size(name: str, payloads: AnyPayload) -> float:
    """Size of a parameter of the heaviest payload, which standard deviations are relative to."""
    power = 0 if name == "M" else 1 if name.startswith("M") else 2
    return payloads.mass * payloads.reach**power


def _poses(model: Model, payloads: AnyPayload, wishes: Wishes, share: float, seed: int) -> Plan:
    """Rests at poses that distinguish the gravity of a payload, which is that of runs without a name.

    `share` is the share of each joint's range, about the start, in which the poses are.
    """
    calm = replace(
        wishes.margins,
        velocity=max(wishes.margins.velocity, 1.0 - CALM),
        acceleration=max(wishes.margins.acceleration, 1.0 - CALM**2),
        jerk=max(wishes.margins.jerk, 1.0 - CALM**2),
    )
    limits, _ = usable(model.robot, calm)
    start = wishes.start if wishes.start is not None else _folded(model, payloads, wishes, limits, seed)[0]
    window = 0.5 * share * (limits.position_upper - limits.position_lower)
    window = window if wishes.window is None else np.minimum(window, wishes.window)
    limits, assumed = usable(model.robot, calm, window, start)
    with in_words_of(model.robot):
        run = static_poses(
            Workspace(limits, wishes.tick, wishes.clearances), POSES, Model(model.robot, (Payload(""),)),
            dwell=DWELL, seed=seed,
        )  # fmt: skip
    return Plan.of(
        run.trajectory, model, margins=vars(calm), tick=wishes.tick,
        assumed=(*assumed, *run.notes), details={"kind": "poses for a payload"},
    )  # fmt: skip


def _folded(
    model: Model, payloads: AnyPayload, wishes: Wishes, limits: Limits, seed: int
) -> tuple[np.ndarray, Need]:
    """The random pose, shape (n,), in which payloads at rest need the least of the torque limits."""
    lower, upper = limits.position_lower, limits.position_upper
    position = np.random.default_rng(seed).uniform(lower, upper, (DRAWN, len(lower)))
    still = np.zeros_like(position)
    states = States(np.arange(DRAWN) * 1.0, position, still, still, still)
    shares = _shares(states, model, payloads, wishes)
    best = int(np.argmin(np.max(shares, axis=(0, 2))))
    return position[best], Need.of(model, shares[:, [best]], shares[0, [best]])


def _require(need: Need, payloads: AnyPayload) -> None:
    """Refuse payloads that need more than a torque limit."""
    if need.share > 1.0:
        cure = "Give a fit of the arm (--fit), or try" if need.fit_helps else "Try"
        raise Infeasible(f"{payloads}: {need}. {cure} a smaller --up-to or --reach")


def largest_need(motion: Trajectory, model: Model, payloads: AnyPayload, wishes: Wishes) -> Need:
    """The share of the torque limits that any payload and any likely arm needs."""
    states = motion.every(SPACING)
    slow, still = CREEPING * states.velocity, np.zeros_like(states.velocity)
    creeping = _shares(states._replace(velocity=slow, acceleration=still), model, payloads, wishes)
    return Need.of(model, _shares(states, model, payloads, wishes), creeping[0])


def _shares(states: States, model: Model, payloads: AnyPayload, wishes: Wishes) -> np.ndarray:
    """Share of the torque limits that any payload needs, on any likely arm and on the nominal one, (2, t, n).

    Limits are those of the robot without margin; without limits, shares are torques [N m].
    """
    limit = model.robot.limits.torque
    inside, _ = usable(model.robot, Margins(), None, None)
    spread = torque_spread(model, inside, ("",), wishes.sure, wishes.fit)
    bound = TorqueBound(model, limit, ("",), spread)
    columns = body_regressor(model.robot.kinematics, states.motion(), model.robot.flange)
    torque = payloads.largest_torque(bound.torque(states, ""), columns)
    both = np.stack([torque + bound.band(states, ""), torque])
    return both / limit if np.any(np.isfinite(limit)) else both
