"""What is reported of the arms of a type: values a run, changes, and sentences about them."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property

import numpy as np

from ..diagnosis.words.naming import joined, lower, named
from ..text_table import NORMAL_95, digits
from .compared import Difference
from .drift import CREEP, ArmDrift, Found, drift
from .kind import Cause
from .learned import Learned
from .runs import ArmRuns


@dataclass(frozen=True, eq=False)
class KindReport:
    """Arms of one type.

    Attributes:
        key: Identifies the type of arm.
        learned: What its arms teach about each other.
        drifts: Drifts of each arm.
    """

    key: str
    learned: Learned
    drifts: Mapping[str, ArmDrift]

    @classmethod
    def of(cls, key: str, learned: Learned, alarms_per_year: float) -> "KindReport":
        """Ask every arm what changed."""
        found = {arm: drift(learned, runs, alarms_per_year) for arm, runs in learned.arms.items()}
        return cls(key, learned, found)

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
        level, _ = self.learned.level(runs)
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
    frame = learned.frame
    cause, joints = frame.causes[found.cause], frame.kind.model.robot.joints
    amount = amount_words(found.amount, found.std, found.usual, cause.unit)
    when = (
        f"since {date_words(found.day)} ({date_words(found.interval[0])} to {date_words(found.interval[1])})"
    )
    kind = "step or creep" if found.either else "creeping" if found.shape == CREEP else "at once"
    text = f"{subject(cause, joints)}: {amount} {when}, {kind}."
    if found.others:
        others = joined([lower(subject(frame.causes[k], joints)) for k in found.others[:3]], "or")
        text += f" Not excluded: {others}."
    return text


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
