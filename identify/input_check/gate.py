"""The check of recordings before anything is fitted: what a person would suspect before missing physics.

Each mistake is weighed by how well the arm's bodies, of any mass, explain the efforts without it; sign and
unit of an effort by the described masses and by friction, which brakes.
"""

from collections.abc import Sequence

import numpy as np

from ..arm.robot import Robot
from ..errors import WrongInput
from ..proposal.agreement import Sampled, posterior, sampled
from ..proposal.drives import described, gains
from ..recordings.recording import EFFORT, Recording
from .drives import suspect_drives
from .hypotheses import Mistake, log_odds, thinned
from .suspicion import Suspicion

MOST = 400
"""Samples that are weighed, at most: some hundred hypotheses are fitted to them."""


def require_plausible(runs: Sequence[Recording], robot: Robot) -> list[str]:
    """Make sure that recordings are of this robot, in units and order of its description.

    Returns:
        Warnings about mistakes that are likely and not certain.

    Raises:
        WrongInput: Surely not; says what is wrong and what to do.
    """
    warnings = []
    for run in runs:
        suspicion = suspect(run, robot)
        if suspicion is not None and suspicion.certain:
            raise WrongInput(
                f"{run.name}: {suspicion}. If the recording is right, --as-recorded takes it as it is"
            )
        warnings += [f"{run.name}: {suspicion}"] if suspicion is not None else []
    return warnings


def suspect(run: Recording, robot: Robot) -> Suspicion | None:
    """The likeliest mistake in a recording, if one is likelier than none."""
    log = _sampled(run)
    if log is None:
        return None
    suspicion = _by_bodies(robot, log)
    if suspicion is not None:
        return suspicion
    stated = np.ones(robot.dof) if "torque" in run.signals else robot.drive_gain
    if not described(robot) or ("torque" not in run.signals and np.all(stated == 1.0)):
        return None
    return suspect_drives(robot, gains(robot, log), stated)


def _sampled(run: Recording) -> Sampled | None:
    """Positions and efforts at the same samples; None where there are too few."""
    name = next((one for one in EFFORT if one in run.signals), "")
    if not name or min(len(run.signals["position"]), len(run.signals[name])) < 100:
        return None
    position, effort = run.signals["position"], run.signals[name]
    known = np.isfinite(position.values).all(axis=1)
    time = position.time[known]
    efforts = np.column_stack([np.interp(time, effort.time, one) for one in effort.values.T])
    if not np.isfinite(efforts).all() or np.any(np.diff(time) <= 0.0):
        return None
    return sampled(time, position.values[known], efforts)


def _by_bodies(robot: Robot, log: Sampled) -> Suspicion | None:
    """The likeliest mistake by bodies of any mass."""
    odds, every = log_odds(robot, thinned(log, MOST))
    likely = posterior(odds)
    place, probability = next(iter(likely.items()))
    if place < 0:
        return None
    best: Mistake = every[place]
    return Suspicion(best.what, best.cure, probability, best.robot is not None)
