"""What is reported of the arms of a type: values a run, changes, the values' usual size."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .causes import Cause
from .drift import ArmDrift, drift
from .learned import Learned
from .runs import ArmRuns


@dataclass(frozen=True, eq=False)
class KindReport:
    """Arms of one type.

    Attributes:
        key: Of the type.
        learned: What its arms teach about each other.
        drifts: Of each arm.
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
        """Causes of which there is a value a run."""
        return [self.learned.frame.causes[place] for place in self.learned.scattering]

    def values(self, arm: str) -> tuple[np.ndarray, np.ndarray]:
        """Value of each scattering cause in each run of an arm at reference temperature, and its deviation.

        Of a cause that is a share, the share over nominal. The arm's other runs and the spread between units
        are the prior, so that a run of 20 s is enough. Shapes (r, s).
        """
        runs, frame = self.learned.arms[arm], self.learned.frame
        level, _ = self.learned.level(runs)
        amounts, covariance = self.learned.deviations(runs, level)
        places = np.array([one.place for one in self.scattering])
        usual = np.where(places >= 0, (level[: len(frame.scale)] * frame.scale)[places], 0.0)
        return usual + amounts + self._gains(level), np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))

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
