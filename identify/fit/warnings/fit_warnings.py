"""Warnings about a fit as a whole: its units, its gains, values that cannot be, runs that prove nothing."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ...recordings.recording import EFFORT, Recording
from ...text_table import digits
from ..fit import Fit

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
    if fit.measures == "torque" or fit.gains_unstated or not np.any(fit.estimate.gain_std > 0.0):
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
    """Parameters that stand for themselves alone and are below what physics allows."""
    sign = " a wrong sign of its drive gain does that too;" if fit.unscaled else ""
    warnings = []
    for row, (value, std) in enumerate(zip(fit.estimate.values, fit.estimate.std, strict=True)):
        parameter = fit.base.parameters[fit.base.kept[row]]
        alone = np.count_nonzero(fit.base.regrouping[row]) == 1
        if alone and value < parameter.minimum - IMPOSSIBLE * std:
            fact = "negative" if parameter.minimum == 0.0 else f"below {parameter.minimum:g}"
            warnings.append(
                f"{parameter.name} is {fact} ({digits(value)} \N{PLUS-MINUS SIGN} {digits(std)}): "
                f"impossible; something else is in its column;{sign} try --estimator consistent"
            )
    return tuple(warnings)


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
