"""Report on the arms of a type: values of each run, changes, and sentences about them."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property

import numpy as np

from ..diagnosis.words.naming import joined, joint_words, lower, named
from ..text_table import NORMAL_95, digits
from .compared import Difference
from .drift import ArmDrift, DetectedChange, at_first, drift, scatter_among
from .evidence import CREEP
from .kind import Cause
from .learned import Learned
from .runs import ArmRuns
from .scatter import Scatter
from .strangers import Odd, levels_of
from .suspects import EXCHANGE, GEAR, TOOL, Suspect


@dataclass(frozen=True, eq=False)
class KindReport:
    """Report on the arms of one type.

    Attributes:
        key: Identifier of the type.
        learned: Statistics of the type.
        scatter: Scatter of its runs.
        drifts: Changes of each arm, by its name.
    """

    key: str
    learned: Learned
    scatter: Scatter
    drifts: Mapping[str, ArmDrift]

    @classmethod
    def of(
        cls, key: str, learned: Learned, alarms_per_year: float, executor: Executor | None = None
    ) -> "KindReport":
        """Search every arm for changes, one after the other or each as a task of an executor."""
        apply = executor.map if executor else map
        arms, levels = list(learned.arms), levels_of(learned)
        statistics = [replace(learned, arms={})] * len(arms)  # without the runs of the other arms
        runs, rates = list(learned.arms.values()), [alarms_per_year] * len(arms)
        states = dict(zip(arms, apply(at_first, statistics, runs, rates), strict=True))
        scatter = scatter_among(learned, states)
        others = [{name: level for name, level in levels.items() if name != arm} for arm in arms]
        drifts = apply(drift, statistics, runs, rates, [scatter] * len(arms), others)
        return cls(key, learned, scatter, dict(zip(arms, drifts, strict=True)))

    @cached_property
    def wearing(self) -> list[Cause]:
        """Causes that wear, for which each run has a value."""
        return [cause for cause in self.learned.frame.causes if cause.wears]

    def values(self, arm: str) -> tuple[np.ndarray, np.ndarray]:
        """Values of the causes that wear in each run of an arm at reference temperature, and their stds.

        For a relative cause, the value is the share relative to nominal. The arm's other runs and the spread
        between units are the prior, so a run of 20 s is enough. Both have shape (r, s).
        """
        runs, frame = self.learned.arms[arm], self.learned.frame
        level = self.drifts[arm].level
        amounts, covariance = self.learned.deviations(runs, level)
        wearing = [k for k, place in enumerate(self.learned.scattering) if frame.causes[place].wears]
        places = np.array([frame.unknown_of(cause) for cause in self.wearing])
        usual = np.where(places >= 0, (level[: len(frame.scale)] * frame.scale)[places], 0.0)
        stds = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        return usual + amounts[:, wearing], stds[:, wearing]


def temperature_of(runs: ArmRuns) -> np.ndarray:
    """Mean temperature of each run, shape (r,) [degC]; NaN where it was not measured."""
    return np.array([float(np.mean(run.summary.temperature)) for run in runs.runs])


FEW = 3.0
"""Number of standard deviations from which a value is not zero, and a change can be stated relative to it."""
DAY = 86400.0
"""Duration of a day [s]."""


def subject(cause: Cause | Difference, joints: tuple[str, ...]) -> str:
    """The cause in words: Coulomb friction of joint 3; spring balancer of joint 2, K0."""
    acting = [cause.joint] if cause.joint >= 0 else []
    text = named(cause.effect, acting, joints)
    detail = cause.effect in ("spring_balancer", "payload", "link_inertia", "joint_spring")
    return f"{text}, {cause.parameter}" if detail else text


def change_words(learned: Learned, change: DetectedChange) -> str:
    """A sentence about a change: what changed, by how much, since when, and its rivals."""
    joints = learned.frame.kind.model.robot.joints
    first, last = (date_words(day) for day in change.interval)
    when = f"since {date_words(change.day)} ({first} to {last})"
    kind = "step or creep" if change.either_shape else "creeping" if change.shape == CREEP else "at once"
    text = f"{what_words(learned, change)} {when}, {kind}."
    if change.suspect.name == EXCHANGE:
        text += f" Its parameters are those of {change.like}." if change.like else ""
    if change.rivals:
        rivals = [lower(suspect_words(learned, rival, joints)) for rival in change.rivals[:3]]
        text += f" Not excluded: {joined(rivals, 'or')}."
    return text


def odd_words(learned: Learned, odd: Odd) -> str:
    """A sentence about an outlier run."""
    count = len(learned.frame.scale)
    if odd.suspect.name == EXCHANGE:
        reason = (
            f"its parameters match a run of {odd.like}"
            if odd.like
            else f"{odd.beyond} of {count} parameters are off, so it is a bad run or a run of an unknown arm"
        )
    elif odd.suspect.name == TOOL:
        reason = f"{lower(_tool_words(learned, odd.suspect, odd.amounts, odd.stds))}, in this run only"
    else:
        usual = np.full(len(odd.amounts), np.nan)
        words = _amounts_words(learned, odd.suspect, odd.amounts, odd.stds, usual)
        reason = f"{lower(words)}, in this run only"
    return f"The run of {date_words(odd.day)} shows no lasting change of the arm: {reason}."


def what_words(learned: Learned, change: DetectedChange) -> str:
    """A change in words, with all of its consequences."""
    if change.suspect.name == EXCHANGE:
        count = len(learned.frame.scale)
        changed = int(np.sum(np.abs(change.amounts[:count]) > FEW * change.stds[:count]))
        return f"Another arm under this name: {changed} of {count} parameters changed"
    if change.suspect.name == TOOL:
        return _tool_words(learned, change.suspect, change.amounts, change.stds)
    return _amounts_words(learned, change.suspect, change.amounts, change.stds, change.usual)


def suspect_words(learned: Learned, suspect: Suspect, joints: tuple[str, ...]) -> str:
    """A suspect in words."""
    if suspect.name == EXCHANGE:
        return "Another arm"
    if suspect.name == TOOL:
        return "A payload on the flange"
    first = learned.frame.causes[suspect.causes[0]]
    return (
        f"All friction of {joint_words(first.joint, joints)}"
        if suspect.name == GEAR
        else subject(first, joints)
    )


def _tool_words(learned: Learned, suspect: Suspect, amounts: np.ndarray, stds: np.ndarray) -> str:
    """Mass and center of a payload, as far as they can be determined."""
    names = [learned.frame.causes[k].parameter for k in suspect.causes]
    estimates = dict(zip(names, zip(amounts, stds, strict=True), strict=True))
    mass, std = estimates.get("M", (0.0, np.inf))
    if abs(mass) < FEW * std:
        return "Another payload on the flange, whose mass cannot be determined"
    center = [estimates[name][0] / mass for name in ("MX", "MY", "MZ") if name in estimates]
    millimeters = joined([f"{1e3 * coordinate:.0f}" for coordinate in center], "and")
    change = "A payload on" if mass > 0.0 else "A payload removed from"
    return (
        f"{change} the flange: {digits(abs(mass), 3)} ± {digits(NORMAL_95 * std, 2)} kg, its center "
        f"{millimeters} mm from the flange in x, y and z"
    )


def _amounts_words(
    learned: Learned, suspect: Suspect, amounts: np.ndarray, stds: np.ndarray, usual: np.ndarray
) -> str:
    frame = learned.frame
    joints, causes = frame.kind.model.robot.joints, [frame.causes[k] for k in suspect.causes]
    order = sorted(range(len(causes)), key=lambda k: -abs(amounts[k]) / stds[k])
    shown = [k for k in order if abs(amounts[k]) > FEW * stds[k]] or order[:1]
    words = [
        f"{subject(causes[k], joints)}: {amount_words(amounts[k], stds[k], usual[k], causes[k].unit)}"
        for k in shown
    ]
    return joined([words[0], *(lower(phrase) for phrase in words[1:])], "and")


def bound_words(reports: Sequence[KindReport], alarms_per_year: float) -> str:
    """The bound on false alarms, or the types of arm for which their rate is unknown."""
    unknown = [report for report in reports if not report.scatter.holds]
    if not unknown:
        return f"false alarms: at most {often_words(alarms_per_year)}"
    names = joined([report.learned.frame.kind.model.robot.name for report in unknown])
    return (
        f"rate of false alarms unknown for {names}: there are too few runs, or their scatter does not follow "
        "Student's distribution"
    )


def often_words(a_year: float) -> str:
    """A rate in words, such as "1 per 10 arm-years"."""
    if a_year >= 1.0:
        return f"{digits(a_year, 2)} per arm-year"
    return f"1 per {digits(1.0 / a_year, 2)} arm-years"


def difference_words(difference: Difference, joints: tuple[str, ...]) -> str:
    """A line about a difference between two arms."""
    usual = 1.0 if not difference.unit else difference.first
    words = amount_words(difference.amount, difference.std, usual, difference.unit)
    return f"{subject(difference, joints)}: {words}"


def amount_words(amount: float, std: float, usual: float, unit: str) -> str:
    """An amount in words: "up 12 ± 3 %", or with its unit if the reference value may be zero."""
    direction, half = "up" if amount > 0.0 else "down", NORMAL_95 * std
    if np.isfinite(usual) and abs(usual) > FEW * std:
        if usual < 0.0 and unit:  # for a negative value, such as a preload, up means away from zero
            direction = "down" if amount > 0.0 else "up"
        share = 100.0 / abs(usual)
        return f"{direction} {digits(share * abs(amount), 2)} ± {digits(share * half, 2)} %"
    return f"{direction} {digits(abs(amount), 3)} ± {digits(half, 2)} {unit}".rstrip()


def date_words(day: float) -> str:
    """A date in words, such as "3 May 2026"."""
    date = datetime.fromtimestamp(day * DAY, UTC)
    return f"{date.day} {date:%b %Y}"
