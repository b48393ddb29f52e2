"""What is reported of the arms of a type: values a run, changes, and sentences about them."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property

import numpy as np

from ..diagnosis.words.naming import joined, joint_words, lower, named
from ..text_table import NORMAL_95, digits
from .compared import Difference
from .drift import ArmDrift, Found, at_first, drift, scatter_among
from .evidence import CREEP
from .history import State
from .kind import Cause
from .learned import Learned
from .runs import ArmRuns
from .scatter import Scatter
from .strangers import Odd, levels_of
from .suspects import EXCHANGE, GEAR, TOOL, Suspect


@dataclass(frozen=True, eq=False)
class KindReport:
    """Arms of one type.

    Attributes:
        key: Identifies the type of arm.
        learned: What its arms teach about each other.
        scatter: How its runs scatter.
        drifts: Drifts of each arm.
    """

    key: str
    learned: Learned
    scatter: Scatter
    drifts: Mapping[str, ArmDrift]

    @classmethod
    def of(
        cls, key: str, learned: Learned, alarms_per_year: float, executor: Executor | None = None
    ) -> "KindReport":
        """Ask every arm what changed; one after the other, or each as a task of an executor."""
        each = executor.map if executor else map
        levels, arms = levels_of(learned), list(learned.arms)
        alone = [replace(learned, arms={arm: learned.arms[arm]}) for arm in arms]
        states = dict(zip(arms, each(_at_first, alone, [alarms_per_year] * len(arms)), strict=True))
        scatter = scatter_among(learned, states)
        others = [{name: level for name, level in levels.items() if name != arm} for arm in arms]
        rest = ([alarms_per_year] * len(arms), [scatter] * len(arms), others)
        return cls(key, learned, scatter, dict(zip(arms, each(_drift, alone, *rest), strict=True)))

    @cached_property
    def scattering(self) -> list[Cause]:
        """Causes of which there is a value a run: those that wear."""
        return [one for one in self.learned.frame.causes if one.wears]

    def values(self, arm: str) -> tuple[np.ndarray, np.ndarray]:
        """Value of each scattering cause in each run of an arm at reference temperature, and its deviation.

        Of a cause that is a share, the share over nominal. The arm's other runs and the spread between units
        are the prior, so that a run of 20 s is enough. Shapes (r, s).
        """
        runs, frame = self.learned.arms[arm], self.learned.frame
        level = self.drifts[arm].level
        amounts, covariance = self.learned.deviations(runs, level)
        wearing = [k for k, place in enumerate(self.learned.scattering) if frame.causes[place].wears]
        places = np.array([one.place for one in self.scattering])
        usual = np.where(places >= 0, (level[: len(frame.scale)] * frame.scale)[places], 0.0)
        stds = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        return usual + amounts[:, wearing] + self._gains(level), stds[:, wearing]

    def _gains(self, level: np.ndarray) -> np.ndarray:
        """Logarithm of an arm's drive gains over the nominal ones, where the cause is one, shape (s,)."""
        frame = self.learned.frame
        own, first = level[: len(frame.scale)] * frame.scale, len(frame.kind.base.kept)
        return np.array(
            [own[first + one.joint] if one.effect == "drive_gain" else 0.0 for one in self.scattering]
        )


def _at_first(alone: Learned, alarms_per_year: float) -> State | None:
    [runs] = alone.arms.values()
    return at_first(alone, runs, alarms_per_year)


def _drift(
    alone: Learned, alarms_per_year: float, scatter: Scatter, others: Mapping[str, np.ndarray]
) -> ArmDrift:
    [runs] = alone.arms.values()
    return drift(alone, runs, alarms_per_year, scatter, others)


def temperature_of(runs: ArmRuns) -> np.ndarray:
    """Mean temperature of each run, shape (r,) [degC]; NaN where it was not measured."""
    return np.array([float(np.mean(run.summary.temperature)) for run in runs.runs])


FEW = 3.0
"""Deviations over which a value is not zero, so that a change may be stated as a share of it."""
DAY = 86400.0


def subject(cause: Cause | Difference, joints: tuple[str, ...]) -> str:
    """What a cause is about: Coulomb friction of joint 3; spring balancer of joint 2, K0."""
    places = [cause.joint] if cause.joint >= 0 else []
    text = named(cause.effect, places, joints)
    detail = cause.effect in ("spring_balancer", "payload", "link_inertia", "joint_spring")
    return f"{text}, {cause.parameter}" if detail else text


def change_words(learned: Learned, found: Found) -> str:
    """A sentence about a change: what, by how much, since when, and what else it may be."""
    joints = learned.frame.kind.model.robot.joints
    when = (
        f"since {date_words(found.day)} ({date_words(found.interval[0])} to {date_words(found.interval[1])})"
    )
    kind = "step or creep" if found.either else "creeping" if found.shape == CREEP else "at once"
    text = f"{what_words(learned, found)} {when}, {kind}."
    if found.suspect.name == EXCHANGE:
        text += f" Its parameters are those of {found.like}." if found.like else ""
    if found.others:
        others = joined([lower(suspect_words(learned, one, joints)) for one in found.others[:3]], "or")
        text += f" Not excluded: {others}."
    return text


def odd_words(learned: Learned, odd: Odd) -> str:
    """A sentence about a run out of line."""
    count = len(learned.frame.scale)
    if odd.suspect.name == EXCHANGE:
        what = (
            f"it is a run of {odd.like}, by its parameters"
            if odd.like
            else f"{odd.beyond} of {count} parameters are off: a bad run, or of an arm that is not here"
        )
    elif odd.suspect.name == TOOL:
        what = f"{lower(_tool_words(learned, odd.suspect, odd.amounts, odd.stds))}, in this run only"
    else:
        usual = np.full(len(odd.amounts), np.nan)
        what = (
            f"{lower(_amounts_words(learned, odd.suspect, odd.amounts, odd.stds, usual))}, in this run only"
        )
    return f"The run of {date_words(odd.day)} is no change of the arm: {what}."


def what_words(learned: Learned, found: Found) -> str:
    """What happened, with all its consequences."""
    if found.suspect.name == EXCHANGE:
        count = len(learned.frame.scale)
        apart = int(np.sum(np.abs(found.amounts[:count]) > FEW * found.stds[:count]))
        return f"Another arm under this name: {apart} of {count} parameters changed"
    if found.suspect.name == TOOL:
        return _tool_words(learned, found.suspect, found.amounts, found.stds)
    return _amounts_words(learned, found.suspect, found.amounts, found.stds, found.usual)


def suspect_words(learned: Learned, suspect: Suspect, joints: tuple[str, ...]) -> str:
    """What a suspect is about."""
    if suspect.name == EXCHANGE:
        return "Another arm"
    if suspect.name == TOOL:
        return "A body on the flange"
    first = learned.frame.causes[suspect.causes[0]]
    return (
        f"All friction of {joint_words(first.joint, joints)}"
        if suspect.name == GEAR
        else subject(first, joints)
    )


def _tool_words(learned: Learned, suspect: Suspect, amounts: np.ndarray, stds: np.ndarray) -> str:
    """A body's mass and where its centre is, as far as runs show that."""
    names = [learned.frame.causes[k].parameter for k in suspect.causes]
    given = dict(zip(names, zip(amounts, stds, strict=True), strict=True))
    mass, std = given.get("M", (0.0, np.inf))
    if abs(mass) < FEW * std:
        return "Another body on the flange, whose mass is not known"
    centre = [given[one][0] / mass for one in ("MX", "MY", "MZ") if one in given]
    where = joined([f"{1e3 * one:.0f}" for one in centre], "and")
    less = "A body" if mass > 0.0 else "A body less"
    return (
        f"{less} on the flange: {digits(abs(mass), 3)} ± {digits(NORMAL_95 * std, 2)} kg, its centre "
        f"{where} mm off the flange in x, y and z"
    )


def _amounts_words(
    learned: Learned, suspect: Suspect, amounts: np.ndarray, stds: np.ndarray, usual: np.ndarray
) -> str:
    frame = learned.frame
    joints, causes = frame.kind.model.robot.joints, [frame.causes[k] for k in suspect.causes]
    order = sorted(range(len(causes)), key=lambda k: -abs(amounts[k]) / stds[k])
    shown = [k for k in order if abs(amounts[k]) > FEW * stds[k]] or order[:1]
    each = [
        f"{subject(causes[k], joints)}: {amount_words(amounts[k], stds[k], usual[k], causes[k].unit)}"
        for k in shown
    ]
    return joined([each[0], *(lower(one) for one in each[1:])], "and")


def bound_words(reports: Sequence[KindReport], alarms_per_year: float) -> str:
    """How often an alarm is false at most; where scatter is not understood, that this is not known."""
    unknown = [one for one in reports if not one.scatter.holds]
    if not unknown:
        return f"false alarms: at most {often_words(alarms_per_year)}"
    names = joined([one.learned.frame.kind.model.robot.name for one in unknown])
    return f"how often alarms are false is not known of {names}: runs are too few, or scatter by no known law"


def often_words(a_year: float) -> str:
    """A rate in whole numbers: 1 an arm and 10 years."""
    if a_year >= 1.0:
        return f"{digits(a_year, 2)} an arm and year"
    return f"1 an arm and {digits(1.0 / a_year, 2)} years"


def difference_words(one: Difference, joints: tuple[str, ...]) -> str:
    """A line about what differs between two arms."""
    usual = 1.0 if not one.unit else one.first
    return f"{subject(one, joints)}: {amount_words(one.amount, one.std, usual, one.unit)}"


def amount_words(amount: float, std: float, usual: float, unit: str) -> str:
    """Up 12 ± 3 %; or the amount with its unit where what it is a share of may be zero."""
    way, half = "up" if amount > 0.0 else "down", NORMAL_95 * std
    if np.isfinite(usual) and abs(usual) > FEW * std:
        if usual < 0.0 and unit:  # of a negative value, such as a preload, up is farther from zero
            way = "down" if amount > 0.0 else "up"
        share = 100.0 / abs(usual)
        return f"{way} {digits(share * abs(amount), 2)} ± {digits(share * half, 2)} %"
    return f"{way} {digits(abs(amount), 3)} ± {digits(half, 2)} {unit}".rstrip()


def date_words(day: float) -> str:
    """A day as 3 May 2026."""
    date = datetime.fromtimestamp(day * DAY, UTC)
    return f"{date.day} {date:%b %Y}"
