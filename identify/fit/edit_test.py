"""Edit test: a payload is attached or removed, and the fit predicts that run without a refit.

A good prediction of another motion with the same payload shows only interpolation. A run with a payload that
no run of the fit carried tests the masses themselves: an error there is an error in every simulation.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..text_table import digits
from .agreement import Agreement, Scores
from .fit import Fit
from .settled_gains import open_gains

NAMED = 5
"""Undetermined parameters named in a sentence; tables have the rest."""


class EditTest(NamedTuple):
    """A predicted run with a payload that no run of the fit carried."""

    run: str  # name of the run
    body: str  # name of the attached payload; empty if the payload of the fitted runs was removed
    residual: np.ndarray  # root mean square of measured minus predicted torque, shape (n,) [N m]
    relative: np.ndarray  # residual over the root mean square of the measured torque, shape (n,) [-]
    beside: np.ndarray  # residual of the other held-out runs, or else of the runs used, shape (n,) [N m]
    held_out: bool  # whether `beside` is from held-out runs


def edits(held_out: Mapping[str, str], used: Collection[str]) -> dict[str, str]:
    """Held-out runs whose payload no run of the fit carries, with the name of that payload."""
    return {run: body for run, body in held_out.items() if body not in used}


def edit_tests(fit: Fit) -> list[EditTest]:
    """Edit tests of a fit; none without a held-out run with a new payload and a run to compare it with."""
    held_out: Sequence[Agreement | Scores] = fit.validation or [run for run in fit.scores if run.held_out]
    used: Sequence[Agreement | Scores] = fit.agreement or [run for run in fit.scores if not run.held_out]
    unedited = [run for run in held_out if run.run not in fit.edits]
    compared = unedited or used
    if not compared:
        return []
    beside = np.sqrt(np.mean([run.residual_rms**2 for run in compared], axis=0))
    return [
        EditTest(run.run, fit.edits[run.run], run.residual_rms, run.relative, beside, bool(unedited))
        for run in held_out
        if run.run in fit.edits
    ]


def edit_sentences(fit: Fit) -> list[str]:
    """One sentence for each edit test, and one about the parameters that the runs do not determine."""
    tests = edit_tests(fit)
    return [*(_sentence(fit, test) for test in tests), *(_undetermined(fit) if tests else [])]


def _sentence(fit: Fit, test: EditTest) -> str:
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = int(np.argmax(np.nan_to_num(test.residual / test.beside)))
    robot = fit.model.robot
    unit, percent = robot.units("N m")[worst], digits(100.0 * test.relative[worst], 2)
    change = f"payload '{test.body}' attached" if test.body else "the payload removed"
    others = "the other held-out runs" if test.held_out else "the runs used"
    return (
        f"Edit test with {change} and no refit ({test.run}): the residual of {robot.joints[worst]} is "
        f"{digits(test.residual[worst], 3)} {unit}, {percent} % of its torque, against "
        f"{digits(test.beside[worst], 3)} {unit} on {others}. No other joint has a larger ratio."
    )


def _undetermined(fit: Fit) -> list[str]:
    """A sentence that names the parameters and drive gains that the runs used do not determine."""
    names = [parameter.name for parameter in sorted(fit.unclear, key=lambda unclear: -unclear.std_percent)]
    names += sorted(fit.dropped)
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    parts = [f"{', '.join(names[:NAMED])}{more}"] if names else []
    if fit.measures == "current" and fit.estimate.nominal_gains:
        parts.append("the scale of torque and masses, since drive gains are nominal")
    elif gains := [
        fit.model.robot.joints[j] for j in np.flatnonzero(open_gains(fit.estimate, fit.model.robot))
    ]:
        parts.append(f"the drive gain of {', '.join(gains)}")
    return [f"The runs used do not determine: {'; '.join(parts)}."] if parts else []
