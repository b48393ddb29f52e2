"""Finding: one effect that the model leaves out, with its numbers; evidence, and all of a diagnosis."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...model import Model
from ...notebook import InNotebook, counted
from ...preparation.prepare import Filtering
from ...quantity import Quantity as Quantity
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate
from .located import Hinted, Located
from .methods import DiagnosisMethods
from .size import LeftOut, Size


@dataclass(frozen=True, eq=False)
class Trace:
    """One run, thinned out as it was compared."""

    name: str  # of the run
    role: str  # what it was for; "validate" was predicted only
    time: np.ndarray  # shape (r,) [s]
    position: np.ndarray  # shape (r, n) [rad]
    velocity: np.ndarray  # shape (r, n) [rad/s]
    acceleration: np.ndarray  # shape (r, n) [rad/s^2]
    load: np.ndarray  # torque that the gears transmit, nominal, shape (r, n) [N m]
    temperature: np.ndarray  # shape (r, n) [degC]; NaN where it was not measured
    motor_angle: np.ndarray  # angle of each motor's shaft, shape (r, n) [rad]
    measured: np.ndarray  # torque by currents and nominal gains, shape (r, n) [N m]
    before: np.ndarray  # what the nominal model leaves, friction and offsets fitted, shape (r, n) [N m]
    after: np.ndarray  # what is left with everything that was found, shape (r, n) [N m]
    explained: np.ndarray  # torque of each finding, shape (f, r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a diagnosis rests on, for those who draw it, simulate it or build on it."""

    model: Model  # nominal, with the payloads of the runs
    before: np.ndarray  # its parameters nominal, friction and offsets fitted, shape (p,)
    after: np.ndarray  # fitted within their tolerances beside what was found, shape (p,)
    gain_before: np.ndarray  # nominal drive gains, shape (n,) [N m/A]; 1 where torque was recorded
    gain_after: np.ndarray  # the same, fitted within their tolerance, shape (n,) [N m/A]
    noise: np.ndarray  # noise floor of each joint's torque behind the filter, shape (n,) [N m]
    traces: tuple[Trace, ...]  # runs held out first
    filtering: Filtering = Filtering()  # noqa: RUF009  # of all runs
    peak: np.ndarray | None = None  # largest torque of each motor in the fitted runs, shape (n,) [N m]


class Alternative(NamedTuple):
    """What the data do not exclude.

    Attributes:
        effect: Name in the vocabulary.
        joints: Where, from 0.
        probability: That it is this instead.
        answer: What was asked, and its coefficients.
    """

    effect: str
    joints: tuple[int, ...]
    probability: float
    answer: Answer | None = None

    @property
    def listed(self) -> bool:
        """Whether the vocabulary has a name for it."""
        return self.answer is None or self.answer.candidate.listed


@dataclass(frozen=True, eq=False, repr=False)
class Finding:
    """One effect.

    Attributes:
        effect: Name in the vocabulary.
        joints: Where it acts, from 0; empty where it has no joint.
        parameters: Coefficients and shape by name.
        probability: That it is there, and is this.
        alternatives: What the data do not exclude, the most credible first.
        torque: Root mean square of its torque on each joint in the runs fitted, shape (n,) [N m].
        held_out: By how much it lowers twice the negative log likelihood of runs not used for fitting; NaN
            without such runs.
        candidate: What was asked, for columns over other runs.
        alone: Whether one joint alone shows it, though it acts on the whole arm.
        unnamed: Whether as much is left on its joint that depends on something and has no name.
        size: Its torque with an interval; None where that was not asked.
        left_out: Parameters that the data do not determine, and beside what.
        family: Name of the narrowest family in `FAMILIES` that is certain; empty where none is.
        family_probability: That it is any member of that family.
        proven: Whether its effect on fitted blocks and on runs held out excludes zero.
    """

    effect: str
    joints: tuple[int, ...]
    parameters: Mapping[str, Quantity]
    probability: float
    alternatives: tuple[Alternative, ...]
    torque: np.ndarray
    held_out: float
    candidate: Candidate
    alone: bool = False
    unnamed: bool = False
    size: Size | None = None
    left_out: Mapping[str, LeftOut] = field(default_factory=dict)
    family: str = ""
    family_probability: float = float("nan")
    proven: bool = True

    @property
    def listed(self) -> bool:
        """Whether the vocabulary has a name for it."""
        return self.candidate.listed

    @property
    def determined(self) -> dict[str, Quantity]:
        """Parameters that the data determine."""
        return {name: one for name, one in self.parameters.items() if name not in self.left_out}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each parameter that the data determine, in its SI unit."""
        return {name: quantity.interval for name, quantity in self.determined.items()}

    def __getitem__(self, name: str) -> Quantity:
        """One parameter.

        Raises:
            KeyError: It has no such parameter; the message lists those that it has.
        """
        if name not in self.parameters:
            raise KeyError(f"{self.effect} has no parameter '{name}'. It has: {', '.join(self.parameters)}")
        return self.parameters[name]

    def __repr__(self) -> str:
        joints = ", ".join(f"joint {joint + 1}" for joint in self.joints) or "the arm"
        numbers = ", ".join(f"{name} {quantity}" for name, quantity in self.determined.items())
        head = f"Finding {self.effect} of {joints}, {100 * self.probability:.3g} %"
        return f"{head}: {numbers}" if numbers else head


UNCERTAIN = "no recorded quantity with certainty"
"""What a remainder depends on where nothing that was asked predicts it well enough."""


class Remainder(NamedTuple):
    """What no finding accounts for, on one joint.

    Attributes:
        joint: From 0.
        over_noise: Residual over the noise floor [-].
        probability: That structure is left, and not noise alone.
        depends_on: What it depends on, in words: "position", "velocity and position", ...
    """

    joint: int
    over_noise: float
    probability: float
    depends_on: str

    @property
    def predictable(self) -> bool:
        """Whether it depends on anything that was recorded."""
        return self.depends_on != UNCERTAIN


class Share(NamedTuple):
    """One part of the budget."""

    finding: int | None  # place of the finding, undecided ones behind the others; None for no finding
    kind: str  # what it depends on, or that it is noise; empty for a finding
    shares: np.ndarray  # of the misfit's power on each joint, shape (n,) [-]


class Budget(NamedTuple):
    """Where the misfit of the nominal model goes."""

    before: (
        np.ndarray
    )  # misfit of the model fitted within its tolerances, without findings, root mean square, (n,) [N m]
    after: np.ndarray  # with all findings, likewise
    shares: tuple[Share, ...]  # their sum is one on every joint
    held_out: bool  # whether it is of runs held out; else of left-out blocks


class Change(NamedTuple):
    """What one candidate alone would change."""

    effect: str  # its name
    joints: tuple[int, ...]  # where it acts, from 0
    joint: int  # the joint that gains most
    change: float  # of that joint's squared prediction error, relative [-]; below zero it is less
    std: float  # its standard deviation over blocks
    gain: float  # logarithm of how much more probable all blocks are
    which: str = ""  # what sets it apart from others of its effect on its joints, in words


class Moment(NamedTuple):
    """A time at which a run differs from the model as at no other.

    The force on the flange that explains most of it is in the base's axes; NaN where one joint alone sees it.
    """

    run: str  # its name
    start: float  # by the run's time [s]
    end: float  # [s]
    joints: tuple[int, ...]  # that see it, from 0
    direction: np.ndarray  # of the force, shape (3,) [-]
    force: float  # its size [N]


@dataclass(frozen=True, eq=False)
class Improvement:
    """Torque residuals of runs that were not used for fitting, root mean squares, each (n,) [N m].

    Attributes:
        runs: Their names.
        before: By nominal values; friction, offsets and what is unstated are fitted.
        after: With the findings, all parameters fitted within their tolerances.
        noise: Noise floor behind the same filter.
        band: Cut-off of that filter [Hz].
    """

    runs: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray
    noise: np.ndarray
    band: float


@dataclass(frozen=True, eq=False)
class Diagnosis(DiagnosisMethods, InNotebook):
    """What is missing, what is not, and what is undecided.

    Attributes:
        name: Name of the robot or case.
        joints: Names.
        findings: In order of importance; empty if nothing is missing.
        remainders: Joints on which something is left that none of the vocabulary accounts for.
        improvement: On runs held out; None without any.
        runs: Names of the runs fitted.
        suspicions: What may be wrong with the recordings or the description instead, in sentences.
        warnings: What limits the answer, in sentences.
        seconds: How long it took [s].
        tried: Effects that these runs can be asked for, with how many hypotheses there were of each.
        evidence: What it rests on, for pictures and simulation.
        undecided: What is there and has no certain name, each with what it might be.
        budget: Where the misfit goes; None for a diagnosis made without.
        changes: What each candidate alone would change.
        moments: Times at which a run differs from the model as at no other.
        located: The misfit of every joint by what it depends on: the first answer.
        hints: What runs held out show and fitted ones do not.
    """

    name: str
    joints: tuple[str, ...]
    findings: tuple[Finding, ...]
    remainders: tuple[Remainder, ...]
    improvement: Improvement | None
    runs: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0
    tried: Mapping[str, int] = field(default_factory=dict)
    evidence: Evidence | None = None
    undecided: tuple[Finding, ...] = ()
    budget: Budget | None = None
    changes: tuple[Change, ...] = ()
    moments: tuple[Moment, ...] = ()
    suspicions: tuple[str, ...] = ()
    located: tuple[Located, ...] = ()
    hints: tuple[Hinted, ...] = ()

    def __repr__(self) -> str:
        number = counted(len(self.findings), "finding")
        lines = [f"Diagnosis of {self.name}: {number}, {len(self.undecided)} undecided"]
        for one in (*self.findings, *self.undecided)[:7]:
            where = ", ".join(self.joints[joint] for joint in one.joints) or "arm"
            state = "" if one in self.findings else ", undecided"
            lines.append(f"  {one.effect} ({where}): probability {100 * one.probability:.3g} %{state}")
        left = ", ".join(self.joints[one.joint] for one in self.remainders)
        lines += [f"  unexplained on: {left}"] if left else []
        return "\n".join(lines)

    @property
    def unexplained(self) -> bool:
        """Whether something is missing that has no name here."""
        open_ = [one for one in self.undecided if not one.family]
        return bool(self.remainders or open_) or not all(one.listed for one in self.findings)
