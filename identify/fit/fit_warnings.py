"""Warnings about a fit: units, gains, impossible values, poor motions, invalid validation, open values."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product

import numpy as np

from ..arm.motion import Motion
from ..model import Model
from ..preparation.prepare import Prepared
from ..preparation.repeated_motion import first_rows
from ..recordings.recording import EFFORT, Recording
from ..text_table import NORMAL_95, digits
from .base_parameters import BaseParameters, rich_motion
from .equations import Equations
from .estimators import Estimate
from .estimators.compressed import Compressed
from .estimators.least_squares import given_nominal, weighted_solution
from .fit import Fit, Unclear
from .settled_gains import cure, open_by_gain

FACTOR = 3.0
"""Ratio of identified and stated drive gain beyond which tolerance is no explanation: motor constants and
gear ratios are known to some ten percent, while a mass in pounds or grams is wrong by a factor of 2.2 or
1000, and a missing payload by more."""
IMPOSSIBLE = 2.0
"""A value this many standard deviations below its physical minimum is impossible: 1 in 40 by chance."""

OPPOSING = ("Ia", "Fv", "Fc")
"""Rotor inertia, viscous and Coulomb friction of a joint, whose torque opposes its motion."""


def fit_warnings(fit: Fit, equations: Equations) -> tuple[str, ...]:
    """Warnings that follow from the fit and its equations, as sentences, the most important first."""
    return (*unknown_scale(fit), *far_gains(fit), *impossible_values(fit, equations))


def unknown_scale(fit: Fit) -> tuple[str, ...]:
    """A warning if the drive gains are unknown, so that values are in amperes."""
    if not fit.unscaled:
        return ()
    return (
        "currents were recorded and no drive gain is known: every value is per N m/A of its joint and "
        "inertias of different joints do not add up; state [drive] gain (torque constant of the motor "
        "[N m/A] times gear ratio; exidyn init proposes it from the described masses), or identify it with "
        "--payload RUN --mass KG",
    )


def far_gains(fit: Fit) -> tuple[str, ...]:
    """A warning about gains far from the stated ones; more likely, the mass of the payload is wrong."""
    nominal = fit.model.robot.drive_gain
    if fit.measures == "torque" or fit.gains_unstated or not np.any(fit.estimate.gain_estimated):
        return ()
    ratio = fit.estimate.gain / nominal
    far = [
        f"{joint} {digits(r)}"
        for joint, r in zip(fit.model.robot.joints, ratio, strict=True)
        if not 1.0 / FACTOR <= r <= FACTOR
    ]
    if not far:
        return ()
    return (
        f"identified drive gains differ from the stated ones by more than a factor of {FACTOR:g} (identified "
        f"over stated: {', '.join(far)}): check --mass (is its unit kg? did that run carry it?) "
        "and the stated gains",
    )


def impossible_values(fit: Fit, equations: Equations) -> tuple[str, ...]:
    """Warnings about parameters without regrouping that are below their physical minimum.

    Rotor inertia, viscous and Coulomb friction oppose motion. If one of them is negative, the torque may have
    the wrong sign; its reversal is advised only if the equations of the fit agree.
    """
    below, warnings = _impossible(fit), []
    opposing = [[f"{kind}{number}" for kind in OPPOSING] for number in range(1, fit.model.robot.dof + 1)]
    negative = [[name for name in names if name in below] for names in opposing]
    for joint in reversed_joints(equations, fit.estimate.gain, [len(names) for names in negative]):
        warnings.append(
            f"{fit.model.robot.joints[joint]}: {', '.join(negative[joint])} negative, and the torque fits at "
            "least as well if it is reversed: its sign is wrong; reverse it (sign = -1 in a preset, the sign "
            "of [drive] gain, or the joint's axis)"
        )
        below = {name: words for name, words in below.items() if name not in negative[joint]}
    return (*warnings, *(f"{words} try --estimator consistent" for words in below.values()))


def _impossible(fit: Fit) -> dict[str, str]:
    """Parameter name -> start of the warning, for each impossible value."""
    below = {}
    mixed = fit.unscaled and fit.model.robot.dof > 1
    cause = "another effect" + ", or joints whose unknown gains differ share its body" * mixed
    for row, (value, std) in enumerate(zip(fit.estimate.values, fit.estimate.std, strict=True)):
        parameter = fit.base.parameters[fit.base.kept[row]]
        alone = np.count_nonzero(fit.base.regrouping[row]) == 1
        if alone and value < parameter.minimum - IMPOSSIBLE * std:
            fact = "negative" if parameter.minimum == 0.0 else f"below {parameter.minimum:g}"
            below[parameter.name] = (
                f"{parameter.name} is {fact} ({digits(value)} ± {digits(NORMAL_95 * std, 2)}): "
                f"physically impossible, so it contains {cause};"
            )
    return below


def repeated_runs(runs: Sequence[Recording], validate: Sequence[Recording]) -> tuple[str, ...]:
    """Warnings about recordings that are used twice, recognized by their samples rather than their names."""
    twice = "{} and {} are the same recording, used twice: it counts double, and intervals are too narrow"
    not_held_out = "{}: validation on a run that was also used (as {}) proves nothing"
    validated_twice = "{} and {} are the same recording, validated on twice"
    pairs = (
        (twice, combinations(runs, 2)),
        (not_held_out, product(validate, runs)),
        (validated_twice, combinations(validate, 2)),
    )
    return tuple(
        sentence.format(first.name, second.name)
        for sentence, compared in pairs
        for first, second in compared
        if _same_samples(first, second)
    )


def _same_samples(a: Recording, b: Recording) -> bool:
    """Whether positions and efforts are equal; noise-free simulations share positions with any payload."""
    return all(
        name in b.signals and np.array_equal(a.signals[name].values, b.signals[name].values)
        for name in ("position", *(effort for effort in EFFORT if effort in a.signals))
    )


SMALLEST = 0.05
"""A joint with a smaller range over all runs [rad] or [m] counts as not moved: three degrees change gravity
by at most a twentieth, and friction acts too briefly to be distinguished from an offset."""

WORST = 1000.0
"""Condition number beyond which a motion is poor: some combination of parameters then affects the torque a
thousand times less than the best one, so a torque error of 0.1 % hides it. Good motions are near 100."""


def excitation_warnings(joints: Sequence[str], runs: Sequence[Prepared], condition: float) -> tuple[str, ...]:
    """Warnings about the motions used, as sentences; empty if they are sufficient."""
    lower = np.min([run.motion.position.min(axis=0) for run in runs], axis=0)
    upper = np.max([run.motion.position.max(axis=0) for run in runs], axis=0)
    warnings = [
        f"{joint} moves by only {reach:.2g} rad or m in all runs used (limit {SMALLEST}): its friction and "
        "inertia cannot be determined; add a run in which it moves"
        for joint, reach in zip(joints, upper - lower, strict=True)
        if reach < SMALLEST
    ]
    if not condition < WORST:
        warnings.append(
            f"the motion is poor: condition number {condition:.3g} (limit {WORST:g}, good motions are near "
            "100); values may be wrong by more than their standard deviations. "
            "Move all joints, farther and faster"
        )
    return tuple(warnings)


REPEATED = 0.5
"""Share of a held-out run whose motion a fitted run made before, from which on it proves little [-]."""


def repeated_motions(used: Sequence[Prepared], held_out: Sequence[Prepared]) -> list[str]:
    """A warning for each held-out run that repeats the motion of a fitted run with the same payload."""
    return [
        f"{run.name} repeats the motion of {other.name} and proves little: hold out another motion"
        for run in held_out
        for other in used
        if run.motion.payload == other.motion.payload and _repeated(run, other) > REPEATED
    ]


def _repeated(run: Prepared, other: Prepared) -> float:
    """Share of a run whose motion another run has made."""
    positions = [other.decimated_position, run.decimated_position]
    count = len(positions[0])
    return float(np.mean(first_rows(positions, ["", ""])[count:] < count))


OPEN = 30.0
"""Relative standard deviation [%] beyond which a parameter counts as open: its 95 % interval is then more
than half of its value, and Gautier's rule of thumb drops parameters at about this limit."""


def unclear(model: Model, base: BaseParameters, estimate: Estimate, payload: str = "") -> tuple[Unclear, ...]:
    """Parameters with a relative standard deviation above `OPEN`, each with its most informative motion."""
    percent = 100.0 * estimate.std / np.maximum(np.abs(estimate.values), np.finfo(float).tiny)
    uncertain = np.flatnonzero(percent > OPEN)
    if len(uncertain) == 0:
        return ()
    motion = rich_motion(model, payload=payload, seed=7)
    regressor = model.regressor(motion)[:, :, base.kept] / estimate.noise[None, :, None]
    covariance = given_nominal(estimate)  # no motion reveals errors of the nominal gains
    # One more sample with row w reduces the variance by (w c)^2 / (1 + w C w), where c is the column of C.
    projected = regressor @ covariance
    spread = np.sum(projected * regressor, axis=2)
    hints = []
    by_gain = open_by_gain(estimate, model.robot)
    for column in uncertain:
        percents = float(percent[column])
        if column in by_gain:  # only a known torque determines it, no motion does
            hints.append(Unclear(base.names[column], percents, cure(model.robot, by_gain[int(column)])))
            continue
        gain = np.max(projected[:, :, column] ** 2 / (1.0 + spread), axis=1)
        hints.append(Unclear(base.names[column], percents, _in_words(model, motion, gain)))
    return tuple(hints)


def _in_words(model: Model, motion: Motion, gain: np.ndarray) -> str:
    """Words for the common feature of the most informative tenth of random samples."""
    best = gain >= np.quantile(gain, 0.9)
    middle = np.mean(motion.position, axis=0)
    kinds = {
        "accelerate {} hard": np.abs(motion.acceleration),
        "move {} fast": np.abs(motion.velocity),
        "move {} far from the middle of its range": np.abs(motion.position - middle),
    }
    shifts = {}
    for phrase, values in kinds.items():
        excess = (values[best].mean(axis=0) - values.mean(axis=0)) / values.std(axis=0)
        for joint, amount in zip(model.robot.joints, excess, strict=True):
            shifts[phrase.format(joint)] = float(amount)
    first, second = sorted(shifts, key=lambda phrase: -shifts[phrase])[:2]
    # The mean of 40 of 400 samples has a standard deviation of 0.16; half of the first is still significant.
    return f"{first} and {second}" if shifts[second] > max(0.5 * shifts[first], 0.5) else first


AS_WELL = 1e-3
"""Relative increase of the residual's geometric mean over joints that counts as none: reversal does not
change the residual of a joint that shares no body with others, or of all joints together."""
BETTER = 0.1
"""Relative decrease that shows a wrong sign even if only one parameter is negative."""


def reversed_joints(equations: Equations, gain: np.ndarray, negative: Sequence[int]) -> list[int]:
    """Joints whose effort, at drive gains (n,), fits as well or better if it is reversed.

    `negative` is the number of parameters of each joint that oppose its motion and are negative, shape (n,).
    They alone do not show a wrong sign: a missing effect, such as a tilted base, causes them too, and the
    joints that share a body contradict each other if only one of them is reversed.
    """
    doubtful = [joint for joint, count in enumerate(negative) if count]
    several = [joint for joint in doubtful if negative[joint] > 1]
    if not doubtful:
        return []
    compressed = Compressed.of(equations)

    def misfit(joints: Sequence[int]) -> float:
        """Logarithm of the geometric mean over joints of the residual with some efforts reversed."""
        sign = np.ones(len(gain))
        sign[list(joints)] = -1.0
        noise = weighted_solution(replace(equations, gain=sign * gain), compressed)[1]
        return float(np.mean(np.log(np.maximum(noise, np.finfo(float).tiny))))

    plain = misfit([])
    if several and misfit(several) <= plain + AS_WELL:
        return several
    limit = {joint: plain + AS_WELL if joint in several else plain - BETTER for joint in doubtful}
    return [joint for joint in doubtful if misfit([joint]) <= limit[joint]]
