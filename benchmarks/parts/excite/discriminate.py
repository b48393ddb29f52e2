"""Trajectories that distinguish two models, against those that identify one of them best.

An identification run (smallest condition number) leaves two models open. The next run of the same length,
within the same limits, is that run again or the discriminating one. Independent rows come 20 a second (10 Hz
of bandwidth), their noise is 1 % of each joint's rms torque in the identification run.

The size of an effect is not chosen to look well but to be open: that at which the identification run leaves
the probability of choosing right at 70 %; a larger one is distinguished without this. The balancer has its
true size, and the range of joint 2 is what hides it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import (
    JointSpring,
    NonlinearViscousFriction,
    SpringBalancer,
    StribeckFriction,
)
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph
from exidyn.trajectories.discrimination.discriminate import Discriminate
from exidyn.trajectories.discrimination.distinction import distinguish, sentences
from exidyn.trajectories.discrimination.separation import (
    Hypothesis,
    Observation,
    probability,
    separation,
    separation_for,
)
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.search.excite import excite
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Goal, Identify
from exidyn.trajectories.search.setting import Setting
from exidyn.trajectories.search.unknowns import DriveGains

PERIOD, RATE = 10.0, 20.0
"""Length of a run [s], and independent rows a second."""
NOISE = 0.01
"""Of a joint's rms torque."""
OPEN = 0.7
"""Probability of choosing right that identification leaves, where a size is free."""
WINDOW = np.deg2rad(2.0)
"""Of joint 2 each way, in the balancer's runs: what a cautious correction window allows."""


class Effort(NamedTuple):
    """Starts and seconds of each optimisation, the same for either goal, and draws of noise."""

    starts: int
    seconds: float
    draws: int


COLUMNS = ("before", "before_drawn", "again", "again_drawn", "after", "after_drawn")


@dataclass(frozen=True, eq=False)
class Pair:
    """The arm as simulated, and what else explains it.

    Attributes:
        key: Of its figures.
        true: Makes a hypothesis of the size of its effect.
        rival: The other one, nominal.
        limits: Of all runs.
        size: What size means, and in which unit; empty for a fixed one.
        own: Parameters of the true one that are its effect.
    """

    key: str
    true: Callable[[float], Hypothesis]
    rival: Hypothesis
    limits: Limits
    size: str
    own: tuple[str, ...]


def springs() -> Pair:
    """Balancer of the KR270 against a linear spring: both parameters of either free."""
    model = read_model("kr270")
    rest = replace(model, effects=tuple(e for e in model.effects if not isinstance(e, SpringBalancer)))
    free = dict.fromkeys(("Kr", "K0"), np.inf)
    balancer = Hypothesis.of_priors("spring balancer", model, deviations=free)
    spring = Hypothesis.of_priors("linear spring", rest + JointSpring(("joint2",)))
    limits = usable(model.robot).limits
    lower, upper = limits.position_lower.copy(), limits.position_upper.copy()
    middle = 0.5 * (lower[1] + upper[1])
    lower[1], upper[1] = middle - WINDOW, middle + WINDOW
    narrow = replace(limits, position_lower=lower, position_upper=upper)
    return Pair("balancer_or_spring", lambda _: balancer, spring, narrow, "", ("Kr", "K0"))


def frictions() -> Pair:
    """Stribeck against drag of stirred grease on the cobot's elbow, Coulomb and viscous friction free."""
    model = read_model("cobot")
    free = dict.fromkeys(("Fv3", "Fc3"), np.inf)

    def stribeck(size: float) -> Hypothesis:
        return Hypothesis.of_priors("Stribeck", model + StribeckFriction(("joint3",)), {"Fs3": size}, free)

    drag = Hypothesis.of_priors(
        "nonlinear viscous", model + NonlinearViscousFriction(("joint3",)), deviations=free
    )
    size = "Stribeck torque [N m], Coulomb 8"
    return Pair("stribeck_or_viscous", stribeck, drag, usable(model.robot).limits, size, ("Fs3",))


def gain_or_mass() -> Pair:
    """Gain of the KR270's second drive against the mass of link 3: either within 10 %, the rest as drawn.

    As drawn is a deviation of 1 % of every inertial parameter, independently; the mass scales all ten of
    link 3 together.
    """
    model = read_model("kr270")
    model = replace(model, robot=replace(model.robot, inertial_tolerance=0.01))
    held = {f"gain{joint + 1}": 0.0 for joint in range(6)} | {"gain2": 0.1}

    def gain(size: float) -> Hypothesis:
        return Hypothesis.of_priors("drive gain", model + DriveGains(model), {"gain2": size}, held)

    mass = Hypothesis.of_priors("link mass", model)
    link = slice(20, 30)
    body = mass.values[link]
    spread = np.linalg.inv(mass.precision[link, link]) + 0.1**2 * np.outer(body, body)
    precision = mass.precision.copy()
    precision[link, link] = np.linalg.inv(spread)
    limits = usable(model.robot).limits
    rival = replace(mass, precision=precision)
    return Pair("gain_or_mass", gain, rival, limits, "gain error [-]", ("gain2",))


def run_of(goal: Goal, limits: Limits, effort: Effort) -> Motion:
    """The best motion for a goal, at the rows that count."""
    setting = Setting(limits, periods=(PERIOD,))
    found = excite(goal, setting, starts=effort.starts, seconds=effort.seconds)
    return found.series[0].at(np.arange(0.0, PERIOD, 1.0 / RATE)).motion()


def observation_of(model: Model, motion: Motion) -> Observation:
    """Noise as a share of the torque in a motion."""
    torque = model.torque(model.loaded(motion), model.nominal_values)
    return Observation(NOISE * np.sqrt(np.mean(torque**2, axis=0)), RATE * PERIOD)


def study(pair: Pair, effort: Effort) -> dict[str, Any]:
    """Probabilities before and after, by formula and by drawing noise."""
    first = run_of(Identify(Experiment.of(pair.true(0.0).model)), pair.limits, effort)
    observation = observation_of(pair.true(0.0).model, first)
    size = 1.0
    if pair.size:  # separation grows with its square
        one = separation(pair.true(1.0), pair.rival, first, observation).separation
        size = float(np.sqrt(separation_for(OPEN) / one))
    true = pair.true(size)
    separated = separation(true, pair.rival, first, observation)
    other = replace(pair.rival, values=separated.hypothesis.values)  # as it is if it is the true one
    back = separation(other, true, first, observation)
    known = separation(true, true, first, observation).hypothesis
    earlier = np.array([[0.0, separated.separation], [back.separation, 0.0]])
    goal = Discriminate((known, separated.hypothesis), observation, earlier)
    second = run_of(goal, pair.limits, effort)
    found: dict[str, Any] = {"size": size if pair.size else np.nan}
    runs = {"before": [first], "again": [first, first], "after": [first, second]}
    for name, motions in runs.items():
        found[name] = probability(_over(true, pair.rival, motions, observation))
        found[f"{name}_drawn"] = _drawn(pair, true, motions, observation, effort.draws)
    return found


def _over(true: Hypothesis, rival: Hypothesis, motions: list[Motion], observation: Observation) -> float:
    """Separation over runs one after the other."""
    total = 0.0
    for motion in motions:
        found = separation(true, rival, motion, observation)
        total, rival = total + found.separation, found.hypothesis
    return total


def _drawn(
    pair: Pair, true: Hypothesis, motions: list[Motion], observation: Observation, draws: int
) -> float:
    """Share of draws of truth and noise in which a fit of both models prefers the true one.

    The truth is spread by its prior, but for the effect in question.
    """
    random = np.random.default_rng(0)
    columns, torque = _rows(true, motions, observation)
    held = np.where([name in pair.own for name in true.model.names], np.inf, np.diag(true.precision))
    spread = np.where(held > 0, held, np.inf) ** -0.5
    truths = spread[:, None] * random.normal(size=(len(held), draws))
    seen = torque[:, None] + columns @ truths + random.normal(size=(len(torque), draws))
    misfits = [_misfit(one, motions, observation, seen) for one in (true, pair.rival)]
    return float(np.mean(misfits[0] < misfits[1]))


def _rows(one: Hypothesis, motions: list[Motion], observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    """All rows in units of the noise: columns (r, p), and torque at the hypothesis' values (r,)."""
    columns, torque = [], []
    for motion in motions:
        seen = observation.seen(one, motion)
        columns.append(seen.columns)
        torque.append(seen.torque)
    return np.concatenate(columns).reshape(-1, len(one.values)), np.concatenate(torque).ravel()


def _misfit(one: Hypothesis, motions: list[Motion], observation: Observation, seen: np.ndarray) -> np.ndarray:
    """Chi-squared of a least-squares fit with the priors as rows, for every column of `seen` (r, draws)."""
    columns, own = _rows(one, motions, observation)
    precision = one.precision[np.ix_(one.free, one.free)]
    diagonal = np.diag(precision)
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(precision / np.outer(scale, scale))
    priors = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T * scale
    rows = np.concatenate([columns[:, one.free], priors])
    right = np.concatenate([seen - own[:, None], np.zeros((len(priors), seen.shape[1]))])
    unit = np.linalg.norm(rows, axis=0)
    unit[unit == 0] = 1.0
    move = np.linalg.lstsq(rows / unit, right, rcond=1e-10)[0]
    return np.asarray(np.sum((right - rows / unit @ move) ** 2, axis=0))


def hopeless(effort: Effort) -> dict[str, Any]:
    """Pairs on the cobot that no motion distinguishes, and what would."""
    model = read_model("cobot")
    model = replace(model, robot=replace(model.robot, inertial_tolerance=0.01))
    limits = usable(model.robot).limits
    motion = run_of(Identify(Experiment.of(model)), limits, effort)
    observation = observation_of(model, motion)
    spring = model + SpringBalancer("joint2", d21=0.3, d22=0.1, phi=0.0)
    slack, held = {"Kr": 300.0}, {"K0": 0.0}
    balancer = Hypothesis.of_priors("a balancer that is slack at length zero", spring, slack, held)
    free = dict.fromkeys(("MX2", "MY2"), np.inf)
    weight = Hypothesis.of_priors("the centre of mass of its own link", model, deviations=free)
    pulling, held = model + JointSpring(("joint3",)), {"Ks3": 0.0, "Off3": 0.0}
    hose = Hypothesis.of_priors("a hose that pulls steadily", pulling, {"Ts3": 3.0}, held)
    offset = Hypothesis.of_priors("a current offset", model, deviations={"Off3": np.inf})
    figures: dict[str, Any] = {}
    print("\nPairs that no motion distinguishes")
    for key, true, rival in (("balancer_or_weight", balancer, weight), ("hose_or_offset", hose, offset)):
        fitted = replace(rival, values=separation(true, rival, motion, observation).hypothesis.values)
        (found,) = distinguish(Discriminate((true, fitted), observation), motion, limits, PERIOD)
        print("\n".join(paragraph(sentences([found])[0], "  ")))
        figures[key] = {
            "possible": found.possible,
            "after": found.probability_after,
            "hour": found.probability_hour,
            "remedies": {offer.name: offer.probability for offer in found.remedies},
        }
    return figures


def run(quick: bool) -> dict[str, Any]:
    """Figures of all pairs; prints the tables."""
    effort = Effort(1, 1.2, 1000) if quick else Effort(4, 12.0, 4000)
    figures: dict[str, Any] = {}
    rows = []
    for make in (springs, frictions, gain_or_mass):
        pair = make()
        found = figures[pair.key] = study(pair, effort)
        size = f"{found['size']:.2g} {pair.size}" if pair.size else "that of the arm"
        rows.append(
            [f"{pair.true(1.0).name} or {pair.rival.name}", size, *(100 * found[name] for name in COLUMNS)]
        )
    show(
        "Probability of choosing right [%], by formula and by drawing truth and noise: after the\n"
        "identification run (before), with it once more (again), with the discriminating run instead (after)",
        ["pair, the first is true", "its size", *(name.replace("_", ", ") for name in COLUMNS)],
        rows,
    )
    return figures | hopeless(effort)
