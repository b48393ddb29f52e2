"""Answers: what is said of an arm, how far its parameters are off, and how long it moved for that."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from exidyn.acquire.study.choice_file import possible_effects, settled_findings
from exidyn.acquire.study.other_gains import OtherGain, other_gains, with_gains
from exidyn.identification.diagnosis.belief.questions import belief_of, nameless_torque
from exidyn.identification.diagnosis.belief.suspects import suspects_of
from exidyn.identification.diagnosis.diagnose import Diagnosed, diagnosed
from exidyn.identification.diagnosis.refit import refit
from exidyn.identification.diagnosis.runs.driven import model_torque
from exidyn.identification.errors import ExidynError
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording
from exidyn.trajectories.next_run.choice import DECIDED, choose
from exidyn.trajectories.next_run.offers import TEMPERATURE
from exidyn.trajectories.plans.plan import Plan

from .case import Case, Named, named

ACCURATE = 0.03
"""Torque of all parameters together, over the true one, from which on these are accurate [-]: sensors are
linear to a few per cent."""


@dataclass(frozen=True)
class Answer:
    """What is said of an arm.

    Attributes:
        found: Effects that are named.
        open: Effects that may be there, for all that is known.
        error: Torque by which the fit is off on another motion, over the true one, of the worst joint [-].
        motion: For how long the arm moved [s].
        decided: Whether it is said that nothing is open.
        hands: How often a body was hung on or taken off.
    """

    found: Named
    open: Named
    error: float
    motion: float
    decided: bool
    hands: int

    @classmethod
    def read(cls, line: dict[str, Any]) -> "Answer":
        """From a table of plain values."""
        return cls(**line | {key: named(line[key]) for key in ("found", "open")})

    def right(self, case: Case) -> bool:
        """Whether all that is there is named, nothing else, and of what is alike neither."""
        return self.found == case.concealed and case.alike <= self.open

    def suffices(self, case: Case) -> bool:
        """Whether it is right and accurate; of what is alike no fit is asked."""
        return self.right(case) and (bool(case.alike) or self.error <= ACCURATE)


def of_runs(case: Case, runs: Sequence[Recording], other: Plan, hands: int) -> Answer:
    """What the diagnosis of some runs says of an arm, with the gains that a known body gives."""
    gains: list[OtherGain] = []
    if any(run.payload for run in runs):
        gains = other_gains(identify(runs), case.nominal)
    found = diagnosed(with_gains(case.nominal, gains), [("identify", run) for run in runs])
    suspects = suspects_of(found.search)
    belief = belief_of(found.search, suspects, [], nameless_torque(found.diagnosis, found.search))
    choice = choose(belief, [], [], np.inf, bool(found.diagnosis.remainders))
    settled = named(settled_findings(belief, choice, found.diagnosis)) | _gains(gains)
    plain = named(
        (one.effect, (joint + 1 for joint in one.joints)) for one in found.diagnosis.findings
    ) | _gains(gains)
    # Whichever is right counts for a programme, of which nobody asks whether it has decided.
    best = plain if plain == case.concealed else settled
    moved = sum(run.duration for run in runs)
    error, decided = error_of(case, found, runs, other), choice.verdict == DECIDED
    return Answer(best, named(possible_effects(belief)), error, moved, decided, hands)


def _gains(found: Sequence[OtherGain]) -> Named:
    return named(("drive_gain", (one.joint + 1,)) for one in found)


def error_of(case: Case, found: Diagnosed, runs: Sequence[Recording], other: Plan) -> float:
    """How far the model with what was found, identified again, is off on another motion."""
    try:
        fit = refit(found.diagnosis, [("identify", run) for run in runs])
        assert fit is not None
        model = identified(fit)
    except ExidynError:
        return float("inf")
    true, given = (_torque(one, other) for one in (case.truth[0], model))
    return float(np.max(np.sqrt(np.mean((given - true) ** 2, axis=0) / np.mean(true**2, axis=0))))


def _torque(model: Model, plan: Plan) -> np.ndarray:
    """Of the motors on a motion without a body, (t, n) [N m]."""
    motion, values = plan.trajectory.every(0.02).motion(), model.nominal_values
    motion = replace(motion, temperature=np.full(motion.position.shape, TEMPERATURE))
    load = model_torque(model, motion, values, transmitted=True)
    own = model_torque(model, replace(motion, load=load), values, transmitted=False)
    return (load + own) @ model.robot.to_motors.T
