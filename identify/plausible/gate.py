"""Check of recordings before a fit: mistakes that a person would suspect before missing physics.

The check warns and never rejects: a large effect that no description has makes a correct log look wrong.
"""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import listed
from ..model import Model
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..text_table import digits
from .evidence import Reading
from .flange import body_suspicions
from .gains import TELLS, gains
from .misfit_times import misfit_times
from .mistake import LogFacts
from .samples import joined, sampled_torques
from .search import MOST, Weighed, weigh
from .suspicion import AT_TIMES, NONE_OF_THESE, OTHER_MASSES, Suspicion
from .units import encoder_steps

LIKELY = 0.5
"""Probability beyond which a mistake is reported."""
ALONE = 0.9
"""Probability required if only one of several runs shows a mistake: recorders seldom change between runs."""


def doubts(runs: Sequence[Recording], model: Model) -> list[str]:
    """Sentences on probable mistakes in recordings: common to all of them, or else in single ones."""
    with threadpool_limits(limits=1):  # hundreds of small systems: threads would wait for one another
        bodies = [f"{run.name}: {suspicion}" for run, suspicion in body_suspicions(runs, model)]
        return bodies + _mistakes([run for run in runs if run.payload is None] or list(runs), model)


def _mistakes(runs: Sequence[Recording], model: Model) -> list[str]:
    together, explained = _checked(runs, model)
    if len(runs) == 1:
        return [] if together is None else [f"{runs[0].name}: {together}"]
    # A run that differs from the others corrupts the common evidence.
    if together is None and explained:
        return []
    suspicions = {run.name: suspect([run], model) for run in runs}
    others = {suspicion.name for suspicion in suspicions.values() if suspicion is not None}
    if together is not None and others <= {together.name}:
        return [f"all runs: {together}"]
    return [
        f"{name}: {suspicion}"
        for name, suspicion in suspicions.items()
        if suspicion is not None and (suspicion.probability is None or suspicion.probability > ALONE)
    ]


def suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    """Most probable mistake common to all recordings, if it is more probable than none."""
    with threadpool_limits(limits=1):
        return _checked(runs, model)[0]


def _checked(runs: Sequence[Recording], model: Model) -> tuple[Suspicion | None, bool]:
    """Suspicion about all recordings together, and whether the log fits without a correction.

    There is no suspicion if they are too short or nothing moves.
    """
    usable, logs, stated = sampled_torques(runs, model.robot)
    if not usable:
        return None, True
    reading = Reading(model, joined(logs).thinned(MOST), stated)
    if not reading.log.moving.any():
        return None, True
    torques = all("torque" in run.signals for run in usable)
    servo = all(is_servo_error(run.settings) for run in usable)
    steps = encoder_steps(np.concatenate([run.signals["position"].values for run in usable]))
    facts = LogFacts(model.robot, reading.log, _ratio(reading), torques, servo, steps)
    weighed = weigh(reading, facts)
    return _suspicion(weighed, facts), reading.fits


def _suspicion(weighed: Weighed, facts: LogFacts) -> Suspicion | None:
    likeliest, reading = weighed.named, weighed.plain.reading
    if likeliest is not None and weighed.probability > LIKELY:
        names = tuple(facts.joints[j] for j in likeliest.joints)
        clause = "; ".join(case.clause for case in likeliest.cases)
        pairs = zip(likeliest.mistakes, likeliest.cases, strict=True)
        cure = "; ".join(dict.fromkeys(case.cure or mistake.cure for mistake, case in pairs))
        return Suspicion(likeliest.mistakes[0].name, names, clause, cure, weighed.probability)
    if facts.servo:  # an error of servos is no measured effort
        return None
    if reading.fits:
        return other_masses(reading, facts) if len(reading.evidence.contradicted) else None
    return at_times(reading) or (unexplained(reading, facts.joints) if reading.misfits else None)


def at_times(reading: Reading) -> Suspicion | None:
    """Suspicion of a cause that acts only at times, on several joints at once; the rest of the log fits."""
    times = misfit_times(reading)
    if not times or not reading.without(times).fits:
        return None
    words = listed([f"{first:.1f} to {last:.1f}" for first, last in times])
    clause = f"several joints leave the model together in {words} s, as from a force or frozen values"
    cure = "leave these times out; exidyn contact estimates a force"
    return Suspicion(AT_TIMES, (), f"{clause}; the rest of the log fits", cure, None)


def other_masses(reading: Reading, facts: LogFacts) -> Suspicion:
    """Suspicion that the described bodies, or the unit of the efforts, are wrong: other masses fit."""
    wrong = reading.evidence.contradicted.tolist()
    joints = [facts.joints[j] for j in wrong]
    ratios = [
        f"{digits(facts.ratio[j], 2)} ({facts.joints[j]})" for j in wrong if np.isfinite(facts.ratio[j])
    ]
    words = f" (masses and friction require {', '.join(ratios)} times the stated torque)" if ratios else ""
    clause = f"the efforts of {listed(joints)} fit bodies, but not those of the description{words}"
    cure = "check the unit of the efforts, the drive gains, and the masses; or another arm was recorded"
    return Suspicion(OTHER_MASSES, tuple(joints), clause, cure, None)


def unexplained(reading: Reading, joints: Sequence[str]) -> Suspicion:
    """Suspicion of a cause without a name: which efforts the description does not explain."""
    names, shares = [joints[j] for j in reading.misfits], 100 * np.sqrt(reading.shares[reading.misfits])
    left = ", ".join(f"{name} {digits(share, 2)} %" for name, share in zip(names, shares, strict=True))
    others = "" if len(names) == reading.log.moving.sum() else "; the other joints fit"
    clause = f"the description does not explain the efforts of {listed(names)}"
    cure = "no correction of units, signs or order that exidyn knows makes them fit"
    return Suspicion(
        NONE_OF_THESE, tuple(names), f"{clause} (left of the torque: {left}{others})", cure, None
    )


def _ratio(reading: Reading) -> np.ndarray:
    """Gain from the log over the stated gain, shape (n,); NaN if either is unknown."""
    if not reading.stated:
        return np.full(reading.model.robot.dof, np.nan)
    return np.array([abs(g.value) if g.relative <= TELLS else np.nan for g in gains(reading)])
