"""Warnings about a fit: units, gains, impossible values, motions, runs that prove nothing, what is open."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ..arm.motion import Motion
from ..model import Model
from ..preparation.prepare import Prepared
from ..recordings.recording import EFFORT, Recording
from ..text_table import NORMAL_95, digits
from .base_parameters import BaseParameters, rich_motion
from .estimators import Estimate
from .estimators.nominal_gains import given_nominal
from .fit import Fit, Unclear
from .settled_gains import cure, open_by_gain

FACTOR = 3.0
"""Identified over stated drive gain, or the reverse, from which it is no tolerance: motors' constants and
gear ratios are known to some ten per cent, while a mass in pounds or grams is wrong by 2.2 or 1000, and a
payload that was not there by more."""
IMPOSSIBLE = 2.0
"""Deviations below its physical minimum from which a value is taken as impossible: 1 in 40 by chance."""


def fit_warnings(fit: Fit) -> tuple[str, ...]:
    """All that follow from the fit alone, in sentences, the most important first."""
    return (*unknown_scale(fit), *far_gains(fit), *impossible_values(fit))


def unknown_scale(fit: Fit) -> tuple[str, ...]:
    """Whether amperes had to be taken for torque."""
    if not fit.unscaled:
        return ()
    return (
        "currents were recorded and no drive gain is known: every value is per N m/A of its joint and "
        "inertias of different joints do not add up; state [drive] gain, or identify them with "
        "--payload RUN --mass KG",
    )


def far_gains(fit: Fit) -> tuple[str, ...]:
    """Gains that came out far from what was stated: more likely, the mass of the payload is wrong."""
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
        f"drive gains came out far from those stated (identified over stated: {', '.join(far)}; the limit is "
        f"a factor {FACTOR:g}): check --mass (is its unit kg? did that run carry it?), and the stated gains",
    )


def impossible_values(fit: Fit) -> tuple[str, ...]:
    """Parameters that stand for themselves alone and are below what physics allows.

    Rotor inertia, drag and dry friction oppose motion: where two are negative, the torque is turned round.
    """
    sign = " a wrong sign of its drive gain does that too;" if fit.unscaled else ""
    below, warnings = _impossible(fit), []
    for number, joint in enumerate(fit.model.robot.joints, 1):
        names = [name for name in (f"Ia{number}", f"Fv{number}", f"Fc{number}") if name in below]
        if len(names) > 1:
            warnings.append(
                f"{', '.join(names)} of {joint} are negative: its torque counts against its motion; turn it "
                "(sign = -1 in a preset, the sign of [drive] gain, or the joint's axis)"
            )
            below = {name: words for name, words in below.items() if name not in names}
    return (*warnings, *(f"{words}{sign} try --estimator consistent" for words in below.values()))


def _impossible(fit: Fit) -> dict[str, str]:
    """What is said of each impossible value, by its name."""
    below = {}
    for row, (value, std) in enumerate(zip(fit.estimate.values, fit.estimate.std, strict=True)):
        parameter = fit.base.parameters[fit.base.kept[row]]
        alone = np.count_nonzero(fit.base.regrouping[row]) == 1
        if alone and value < parameter.minimum - IMPOSSIBLE * std:
            fact = "negative" if parameter.minimum == 0.0 else f"below {parameter.minimum:g}"
            below[parameter.name] = (
                f"{parameter.name} is {fact} ({digits(value)} ± {digits(NORMAL_95 * std, 2)}): "
                "impossible; something else is in its column;"
            )
    return below


def repeated_runs(runs: Sequence[Recording], validate: Sequence[Recording]) -> tuple[str, ...]:
    """Recordings that are given twice, recognised by their positions rather than by their names."""
    twice = [
        f"{a.name} and {b.name} are the same recording, used twice: it counts double, and intervals come "
        "out too small"
        for a, b in combinations(runs, 2)
        if _same(a, b)
    ]
    flattering = [
        f"{held_out.name}: validated on a run that was also used (as {used.name}): proves nothing"
        for held_out in validate
        for used in runs
        if _same(held_out, used)
    ]
    again = [
        f"{a.name} and {b.name} are the same recording, validated on twice"
        for a, b in combinations(validate, 2)
        if _same(a, b)
    ]
    return (*twice, *flattering, *again)


def _same(a: Recording, b: Recording) -> bool:
    """Positions alone will not do: simulated without noise, they are the same with and without a payload."""
    return all(
        name in b.signals and np.array_equal(a.signals[name].values, b.signals[name].values)
        for name in ("position", *(effort for effort in EFFORT if effort in a.signals))
    )


SMALLEST = 0.05
"""Range of a joint over all runs [rad] or [m] below which it counts as not moved: three degrees change
gravity by at most a twentieth, and friction acts in them for too short to be distinguished from an offset."""

WORST = 1000.0
"""Condition number from which a motion is poor: some combination of parameters is then seen a thousand
times more weakly than the best, and a torque error of a thousandth is all of it. Good ones are near 100."""


def excitation_warnings(joints: Sequence[str], runs: Sequence[Prepared], condition: float) -> tuple[str, ...]:
    """What the user should know of the motions used, in sentences; empty if they will do."""
    lower = np.min([run.motion.position.min(axis=0) for run in runs], axis=0)
    upper = np.max([run.motion.position.max(axis=0) for run in runs], axis=0)
    warnings = [
        f"{joint} moves by only {reach:.2g} rad or m in all runs used (under {SMALLEST}): its friction and "
        "inertia cannot be found; add a run in which it moves"
        for joint, reach in zip(joints, upper - lower, strict=True)
        if reach < SMALLEST
    ]
    if not condition < WORST:
        warnings.append(
            f"the motion is poor: condition number {condition:.3g} (good ones are near 100, the limit is "
            f"{WORST:g}); values may be wrong by more than their deviations. "
            "Move all joints, farther and faster"
        )
    return tuple(warnings)


ALIKE = 0.02
"""Difference of two motions over their size below which one repeats the other [-]: controllers repeat to
better than a hundredth, and other motions differ by as much as they move."""
APART = 10.0
"""Time by which one recording may begin later in the motion than the other [s]."""
COARSE, FINE = 0.05, 0.001
"""Between the shifts that are tried, of all and around the best of these [s]."""
NEAR = 0.5
"""Difference at the best coarse shift below which the fine ones are tried [-]."""
OVERLAP = 0.5
"""Share of the shorter run that the other has to cover."""


def repeated_motions(used: Sequence[Prepared], held_out: Sequence[Prepared]) -> list[str]:
    """A warning for each run held out with the motion of a fitted one that carries the same."""
    return [
        f"{run.name} repeats the motion of {other.name}, so a good prediction shows that the arm repeats its "
        "motion, not that the model holds for other motions. Hold out a different motion"
        for run in held_out
        for other in used
        if run.motion.payload == other.motion.payload and _difference(run, other) < ALIKE
    ]


def _difference(one: Prepared, other: Prepared) -> float:
    """Root mean square between two motions over their size, at the shift at which it is least [-]."""
    first, second = _even(one, 0.0), _even(other, 0.0)
    reach = round(APART / COARSE)
    coarse = {shift: _apart(first, second, shift) for shift in range(-reach, reach + 1)}
    best = min(coarse, key=lambda shift: coarse[shift])
    if not coarse[best] < NEAR:
        return coarse[best]
    later = np.arange(-COARSE, COARSE, FINE)
    return min(_apart(first, _even(other, float(by)), best) for by in later)


def _even(run: Prepared, later: float) -> np.ndarray:
    """Positions (t, n) every `COARSE`, of so much later [s]."""
    time = run.motion.time - run.motion.time[0]
    at = np.arange(0.0, time[-1], COARSE) + later
    return np.column_stack([np.interp(at, time, joint) for joint in run.motion.position.T])


def _apart(first: np.ndarray, second: np.ndarray, shift: int) -> float:
    """The same of rows (t, n), the second begun so many rows later; infinite where they share too few."""
    here, there = first[max(shift, 0) :], second[max(-shift, 0) :]
    rows = min(len(here), len(there))
    if rows < max(OVERLAP * min(len(first), len(second)), 2):
        return np.inf
    here, there = here[:rows], there[:rows]
    size = float(np.linalg.norm(here - here.mean(axis=0)))
    return float(np.linalg.norm(here - there)) / max(size, 1e-12)


OPEN = 30.0
"""Per cent of its value at which a parameter counts as open: two deviations are then most of it, and
Gautier's rule of thumb drops parameters from about there."""


def unclear(model: Model, base: BaseParameters, estimate: Estimate, payload: str = "") -> tuple[Unclear, ...]:
    """Parameters above `OPEN` per cent, each with the motion most informative about it."""
    percent = 100.0 * estimate.std / np.maximum(np.abs(estimate.values), np.finfo(float).tiny)
    found = np.flatnonzero(percent > OPEN)
    if len(found) == 0:
        return ()
    motion = rich_motion(model, payload=payload, seed=7)
    regressor = model.regressor(motion)[:, :, base.kept] / estimate.noise[None, :, None]
    covariance = given_nominal(estimate)  # no motion shows how wrong nominal gains are
    # One more sample with row w shrinks the variance by (w c)^2 / (1 + w C w), c the column of C.
    seen = regressor @ covariance
    spread = np.sum(seen * regressor, axis=2)
    hints = []
    by_gain = open_by_gain(estimate, model.robot)
    for column in found:
        percents = float(percent[column])
        if column in by_gain:  # no motion shows what only a known torque does
            hints.append(Unclear(base.names[column], percents, cure(model.robot, by_gain[int(column)])))
            continue
        gain = np.max(seen[:, :, column] ** 2 / (1.0 + spread), axis=1)
        hints.append(Unclear(base.names[column], percents, _in_words(model, motion, gain)))
    return tuple(hints)


def _in_words(model: Model, motion: Motion, gain: np.ndarray) -> str:
    """What the most informative tenth of random samples has in common."""
    best = gain >= np.quantile(gain, 0.9)
    middle = np.mean(motion.position, axis=0)
    kinds = {
        "accelerate {} hard": np.abs(motion.acceleration),
        "move {} fast": np.abs(motion.velocity),
        "take {} far from the middle of its range": np.abs(motion.position - middle),
    }
    shifts = {}
    for phrase, values in kinds.items():
        excess = (values[best].mean(axis=0) - values.mean(axis=0)) / values.std(axis=0)
        for joint, amount in zip(model.robot.joints, excess, strict=True):
            shifts[phrase.format(joint)] = float(amount)
    first, second = sorted(shifts, key=lambda phrase: -shifts[phrase])[:2]
    # A mean of forty of four hundred scatters by 0.16; half as much as the first is still significant.
    return f"{first} and {second}" if shifts[second] > max(0.5 * shifts[first], 0.5) else first
