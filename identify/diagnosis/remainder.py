"""Remainder: whether anything is left that goes with the motion, whatever it may be.

Not physics but features: powers, waves and products of what was recorded. They name nothing; where they
explain what no finding does, something is missing.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from ..effects.smooth_sign import smooth_sign
from ..model import Model
from .candidate import Candidate, Thinned
from .driven import Driven
from .finding import Remainder
from .hypothesis import Hypothesis, weighed
from .recolouring import recoloured
from .solution import Solution

Feature = Callable[[Driven, int], list[np.ndarray]]
CREDIBLE = 0.99
"""Probability from which on something is taken to be left."""
MATERIAL = 0.3
"""Share of the noise floor below which what is left changes the residual by less than five per cent, and is
not worth a run."""
AROUND = 161
"""Frequencies whose median is the level about a line; it is known to a tenth."""
WAVES = 6
"""Half waves over a run of what wanders with time; faster than seconds it is noise."""
PASSED = 0.7
"""Share of the highest frequency up to which torque passes the filter as it is [-]."""
SLOWEST = 1.0
"""Of what vibrates [Hz]; slower waves are motions'."""
BEYOND = 2.0
"""Residual over the noise floor from which on something is left, be it seen to go with nothing: drives that
move are noisier than drives at rest, but not by three times the power more."""
LINES = 1e-4
"""Probability with which noise alone has a spectral line that stands out as far."""


@dataclass(frozen=True)
class Left:
    """Features of one kind on one joint, weighed.

    Attributes:
        joint: From 0.
        depends_on: The kind, in words.
        evidence: Logarithm of the Bayes factor against noise alone.
        hypothesis: What was asked.
    """

    joint: int
    depends_on: str
    evidence: float
    hypothesis: Hypothesis


def features(model: Model) -> Iterator[Candidate]:
    """All kinds of features on each joint."""
    for joint in range(model.robot.dof):
        for kind, make in KINDS.items():
            count = _count(kind, model.robot.dof)
            if not count:
                continue

            def columns(run: Driven, joint: int = joint, make: Feature = make) -> np.ndarray:
                own = np.stack(make(run, joint), axis=1)
                whole = np.zeros((*run.torque.shape, own.shape[1]))
                whole[:, joint] = own
                return whole

            yield Candidate(kind, (joint,), columns, ("",) * count, ("",) * count, (-np.inf,) * count)


def asked(model: Model, runs: Sequence[Driven]) -> list[tuple[Candidate, Thinned]]:
    """All features, with their columns."""
    return [(one, Thinned.of(one, runs)) for one in features(model)]


def greatest(
    solution: Solution, every_feature: Sequence[tuple[Candidate, Thinned]], noise: np.ndarray
) -> list[Left]:
    """The kind of features that explains most on each joint, where any is material."""
    every: dict[int, list[Hypothesis]] = {}
    for candidate, thinned in every_feature:
        if not thinned.empty:
            every.setdefault(candidate.joints[0], []).append(weighed(solution, candidate, thinned))
    found = []
    for joint, own in every.items():
        best, _ = recoloured(solution, max(own, key=lambda one: one.evidence))
        torque = float(rms(best.torque, solution.rows.weight[:, best.columns.joints]).max())
        if torque > MATERIAL * noise[joint]:
            found.append(Left(joint, best.candidate.effect, best.evidence, best))
    return found


def remainders(solution: Solution, left: Sequence[Left], rate: float, noise: np.ndarray) -> list[Remainder]:
    """Joints on which something is left, with what explains it best.

    Args:
        solution: With all findings.
        left: What features explain on each joint.
        rate: Of the rows [Hz].
        noise: Noise floor of each joint's torque, shape (n,) [N m].
    """
    every, count = {one.joint: one for one in left}, len(noise) * len(KINDS)
    residual = rms(solution.residual, solution.rows.weight)
    found = []
    for joint in range(len(noise)):
        best, over = every.get(joint), float(residual[joint] / noise[joint])
        if best is not None and best.evidence > least_evidence(len(noise)):
            probability = 1.0 / (1.0 + count * np.exp(-min(best.evidence, 700.0)))
            found.append(Remainder(joint, over, float(probability), best.depends_on))
        elif frequency := line(solution, joint, rate):
            found.append(Remainder(joint, over, 1 - LINES, f"time, at {frequency:.1f} Hz"))
        elif over > BEYOND:
            found.append(Remainder(joint, over, CREDIBLE, "nothing that was recorded"))
    return found


def excess(solution: Solution, joint: int, noise: float) -> float:
    """Power on a joint beyond that of its noise [(N m)^2]; zero where drives that move may be as noisy."""
    residual = float(rms(solution.residual, solution.rows.weight)[joint])
    return residual**2 - noise**2 if residual > BEYOND * noise else 0.0


def least_evidence(dof: int) -> float:
    """Logarithm of the Bayes factor from which on something is taken to be left on one of so many joints."""
    return float(np.log(CREDIBLE / (1 - CREDIBLE)) + np.log(dof * len(KINDS)))


def line(solution: Solution, joint: int, rate: float) -> float:
    """Frequency of a line that two runs have and noise has not [Hz]; zero for none.

    What vibrates does so in every run; a line of one run alone is a swept sine that passed. The residual is
    taken as it is: what makes noise white takes lines away.

    Args:
        solution: Whose residual it is.
        joint: From 0.
        rate: Of the rows [Hz].
    """
    # Runs of different lengths are compared frequency by frequency.
    longest = max(rows.stop - rows.start for rows in solution.rows.runs)
    length = 2 ** int(np.ceil(np.log2(2 * longest)))
    lowest = int(SLOWEST * length / rate)
    every = _over_their_level(solution, joint, lowest, length)
    found = [ratio for ratio in every if ratio is not None]
    if not found:
        return 0.0
    several = min(2, len(found))
    ratios = np.sort(found, axis=0)[-several]
    worst, pairs = int(np.argmax(ratios)), len(found) * (len(found) - 1) / 2 if several == 2 else 1
    # Powers of noise are exponential; the factor allows for a window, by which neighbours are alike.
    chance = -np.expm1(len(ratios) * np.log1p(-min(pairs * np.exp(-several * ratios[worst] / 1.5), 0.5)))
    return float((worst + lowest) * rate / length) if chance < LINES else 0.0


def _over_their_level(
    solution: Solution, joint: int, lowest: int, length: int
) -> Iterator[np.ndarray | None]:
    """Power of each run's residual over the level round about, at one grid of frequencies."""
    counts, residual = solution.whitening.valid[:, joint], solution.residual[:, joint]
    for rows in solution.rows.runs:
        own = residual[rows][counts[rows]]
        if len(own) < 64:
            yield None
            continue
        power = np.abs(np.fft.rfft(own * np.hanning(len(own)), length)) ** 2
        # Beyond that share of the highest frequency the filter has taken the torque away.
        inner = power[lowest : int(PASSED * len(power))]
        window = AROUND * max(length // len(own), 1)
        yield inner / (ndimage.median_filter(inner, window, mode="reflect") / np.log(2))


def rms(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square of rows (r, n) that count, shape (n,)."""
    return np.sqrt(np.sum(values**2 * weight, axis=0) / np.maximum(weight.sum(axis=0), 1.0))


def _position(run: Driven, joint: int) -> list[np.ndarray]:
    q = run.motion.position[:, joint]
    return [f(k * q) for k in (1, 2, 3) for f in (np.cos, np.sin)]


def _velocity(run: Driven, joint: int) -> list[np.ndarray]:
    v = run.motion.velocity[:, joint]
    return [*(smooth_sign(v, width) for width in (0.01, 0.03, 0.1, 0.3)), np.abs(v), v**3]


def _position_and_direction(run: Driven, joint: int) -> list[np.ndarray]:
    sign = smooth_sign(run.motion.velocity[:, joint], 0.003)
    return [sign * one for one in _position(run, joint)]


def _load(run: Driven, joint: int) -> list[np.ndarray]:
    load, v = run.motion.load[:, joint], run.motion.velocity[:, joint]
    share, sign = load / max(float(run.most[joint]), 1e-9), smooth_sign(v, 0.003)
    return [share, share**2, share**3, sign * share, sign * np.abs(share), sign * share**2]


def _acceleration(run: Driven, joint: int) -> list[np.ndarray]:
    return [run.motion.acceleration[:, k] for k in range(run.torque.shape[1])]


def _time(run: Driven, joint: int) -> list[np.ndarray]:
    """Offsets and dry friction that wander, in half waves over the run."""
    t = run.motion.time - run.motion.time[0]
    turn = np.pi * t / max(float(t[-1]), 1e-9)
    sign = smooth_sign(run.motion.velocity[:, joint], 0.003)
    return [kind * np.cos(k * turn) for k in range(1, WAVES + 1) for kind in (np.ones_like(sign), sign)]


def _other_joints(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    torques = [run.torque[:, k] for k in others]
    signs = [smooth_sign(run.motion.velocity[:, k], 0.003) for k in others]
    return torques + signs


def _other_positions(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    q = run.motion.position
    return [f(q[:, k]) for k in others for f in (np.cos, np.sin)]


KINDS: dict[str, Feature] = {
    "position": _position,
    "velocity": _velocity,
    "position and direction": _position_and_direction,
    "load": _load,
    "acceleration": _acceleration,
    "time": _time,
    "other joints' torque or direction": _other_joints,
    "other joints' position": _other_positions,
}


def _count(kind: str, dof: int) -> int:
    fixed = {"position": 6, "velocity": 6, "position and direction": 6, "load": 6, "time": 2 * WAVES}
    return fixed.get(kind, {"acceleration": dof}.get(kind, 2 * (dof - 1)))
