"""Edit test: a payload is put on or taken off, and the fit predicts that run without being fitted again.

A fit that predicts another motion with the same body shows that it interpolates. Only a run whose body is not
that of any run used shows that its masses are masses: what is off there is off in every simulation.
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
    """One run that was predicted with another body than any run used.

    Attributes:
        run: Its name.
        body: Payload that was put on; empty where those of the runs used were taken off.
        residual: Root mean square of measured minus predicted torque, shape (n,) [N m].
        relative: The same over that of the measured torque, shape (n,) [-].
        beside: Residual of the other runs held out, or else of the runs used, shape (n,) [N m].
        held_out: Whether those were held out.
    """

    run: str
    body: str
    residual: np.ndarray
    relative: np.ndarray
    beside: np.ndarray
    held_out: bool


def edits(held_out: Mapping[str, str], used: Collection[str]) -> dict[str, str]:
    """Runs that are predicted with a body that no run used carries -> that body; empty where it is none.

    Args:
        held_out: Run -> name of its payload, empty for none.
        used: Payloads of the runs used, empty for none.
    """
    return {run: body for run, body in held_out.items() if body not in used}


def edit_tests(fit: Fit) -> list[EditTest]:
    """The edit tests of a fit; none where no run held out has another body, or no run was compared."""
    every: Sequence[Agreement | Scores] = fit.validation or [run for run in fit.scores if run.held_out]
    used: Sequence[Agreement | Scores] = fit.agreement or [run for run in fit.scores if not run.held_out]
    same = [run for run in every if run.run not in fit.edits]
    compared = same or used
    if not compared:
        return []
    beside = np.sqrt(np.mean([run.residual_rms**2 for run in compared], axis=0))
    return [
        EditTest(run.run, fit.edits[run.run], run.residual_rms, run.relative, beside, bool(same))
        for run in every
        if run.run in fit.edits
    ]


def edit_sentences(fit: Fit) -> list[str]:
    """One sentence for each edit test, and one that names what the runs used do not determine."""
    tests = edit_tests(fit)
    return [*(_sentence(fit, test) for test in tests), *(_undetermined(fit) if tests else [])]


def _sentence(fit: Fit, test: EditTest) -> str:
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = int(np.argmax(np.nan_to_num(test.residual / test.beside)))
    robot = fit.model.robot
    unit, percent = robot.units("N m")[worst], digits(100.0 * test.relative[worst], 2)
    what = f"payload '{test.body}' put on" if test.body else "the payload taken off"
    others = "the other runs held out" if test.held_out else "the runs used"
    return (
        f"Edit test, {what} and nothing fitted again ({test.run}): the residual of {robot.joints[worst]} is "
        f"{digits(test.residual[worst], 3)} {unit}, {percent} % of its torque, against "
        f"{digits(test.beside[worst], 3)} {unit} on {others}; no joint's ratio is larger."
    )


def _undetermined(fit: Fit) -> list[str]:
    """Directions that the runs used leave open, by name."""
    open_ones = [one.name for one in sorted(fit.unclear, key=lambda one: -one.std_percent)]
    open_ones += sorted(fit.dropped)
    more = f" and {len(open_ones) - NAMED} more" if len(open_ones) > NAMED else ""
    parts = [f"{', '.join(open_ones[:NAMED])}{more}"] if open_ones else []
    if fit.measures == "current" and fit.estimate.nominal_gains:
        parts.append("the scale of torque and masses, since drive gains are nominal")
    elif gains := [
        fit.model.robot.joints[j] for j in np.flatnonzero(open_gains(fit.estimate, fit.model.robot))
    ]:
        parts.append(f"the drive gain of {', '.join(gains)}")
    return [f"The runs used do not determine: {'; '.join(parts)}."] if parts else []
