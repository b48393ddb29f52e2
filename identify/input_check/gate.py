"""The check of recordings before anything is fitted: what a person would suspect before missing physics.

Each mistake is weighed by how well the arm's bodies, of any mass, explain the efforts without it; sign and
unit of an effort by the described masses and by friction, which brakes.
"""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import WrongInput
from ..model import Model
from ..proposal.agreement import Sampled, posterior, sampled
from ..proposal.described_bodies import Stated
from ..proposal.drives import Gain, gains
from ..proposal.mounting import OTHERWISE
from ..recordings.recording import EFFORT, Recording
from .coupled import Coupled
from .drives import NOTHING, as_stated, drive_odds
from .hypotheses import joined, log_odds, thinned, torque_columns, upside_down
from .suspicion import Suspicion

MOST = 400
"""Samples that are weighed, at most: some hundred hypotheses are fitted to them."""


def require_plausible(runs: Sequence[Recording], model: Model) -> list[str]:
    """Make sure that recordings are of this robot, in units and order of its description.

    Returns:
        Warnings about mistakes that are likely and not certain.

    Raises:
        WrongInput: Surely not; says what is wrong and what to do.
    """
    asked = {run.name: suspect([run], model) for run in runs}
    if len(runs) > 1 and not any(one is not None and one.certain for one in asked.values()):
        together = suspect(runs, model)
        asked = asked if together is None else {"all runs": together}
    for name, suspicion in asked.items():
        if suspicion is not None and suspicion.certain:
            raise WrongInput(f"{name}: {suspicion}. If that is right, --as-recorded takes it as it is")
    return [f"{name}: {suspicion}" for name, suspicion in asked.items() if suspicion is not None]


def suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    """The likeliest mistake that all of these recordings have, if one is likelier than none."""
    with threadpool_limits(limits=1):  # hundreds of small systems: threads would wait for one another
        return _suspect(runs, model)


def _suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    logs = [log for log in map(_sampled, runs) if log is not None]
    if not logs:
        return None
    log = joined(logs)
    measured = ["torque" if "torque" in run.signals else "current" for run in runs]
    robot = model.robot
    stated = np.ones(robot.dof) if measured[0] == "torque" else robot.drive_gain
    unknown = measured[0] == "current" and bool(np.all(stated == 1.0)) or len(set(measured)) > 1
    few = thinned(log, MOST)
    odds, every = log_odds(model, few, None if unknown else stated)
    weighed = {(one.what, one.cure): odds[place] for place, one in enumerate(every)} | {NOTHING: odds[-1]}
    if not unknown:
        found, coupled = _by_bodies(model, log, few, stated)
        drives = drive_odds(robot, found, stated, coupled)
        weighed |= {one: odds[-1] + value - drives[NOTHING] for one, value in drives.items()}
        turned = upside_down(model, few)
        if turned is not None and turned.model is not None:
            opposite = as_stated(stated, *_by_bodies(turned.model, log, few, stated)) - as_stated(
                stated, found, coupled
            )
            weighed[turned.what, turned.cure] = odds[-1] + np.log(OTHERWISE) + opposite
            every.append(turned)
    (what, cure), probability = next(iter(posterior(weighed).items()))
    physical = any(one.what == what and one.model is not None for one in every)
    return Suspicion(what, cure, probability, physical) if what else None


def _by_bodies(model: Model, log: Sampled, few: Sampled, stated: np.ndarray) -> tuple[list[Gain], Coupled]:
    """What a description tells of each drive, by all samples, and bodies of any mass of all, by few."""
    columns = torque_columns(model, few.motion)
    each = gains(model.robot, log, Stated.of(model, log.motion))
    return each, Coupled.of(columns, few._replace(effort=few.effort * stated))


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
