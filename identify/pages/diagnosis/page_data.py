"""Page data: a diagnosis as its pages show it, whether it was made just now or read from its files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...diagnosis.findings.finding import Alternative, Change, Diagnosis, Improvement, Moment, Quantity, Trace
from ...diagnosis.findings.quantities import TURNING
from ...diagnosis.improved.forward import Forward
from ...diagnosis.words.answer import plain
from ...diagnosis.words.changes_words import from_table as changes_of
from ...diagnosis.words.misfit import Misfit
from ...diagnosis.words.misfit import from_table as misfit_of
from ...diagnosis.words.moments_words import from_table as moments_of
from ...diagnosis.words.naming import named
from ...diagnosis.words.numbers import array_of, numbers, value_of
from ...diagnosis.words.words import verdict


@dataclass(frozen=True, eq=False)
class Named:
    """One finding.

    Attributes:
        effect: Name in the vocabulary.
        joints: Where it acts, from 0; empty where it has no joint.
        name: The two in words.
        headline: What is missing, and what was gained; of an undecided one, what it may be.
        certainty: How surely it is this, what it might be instead, and what would decide; empty if undecided.
        parameters: Coefficients and shape by name.
        probability: That it is there, and is this.
        alternatives: What the data do not exclude.
        torque: Root mean square of its torque on each joint, shape (n,) [N m].
        held_out: By how much it lowers twice the negative log likelihood of runs held out; NaN without such.
    """

    effect: str
    joints: tuple[int, ...]
    name: str
    headline: str
    certainty: str
    parameters: Mapping[str, Quantity]
    probability: float
    alternatives: tuple[Alternative, ...]
    torque: np.ndarray
    held_out: float


class Left(NamedTuple):
    """What no finding accounts for, on one joint.

    Attributes:
        joint: From 0.
        probability: That it is there.
        depends_on: What it depends on.
        size: How much it is, in words with its unit.
    """

    joint: int
    probability: float
    depends_on: str
    size: str


class Simulated(NamedTuple):
    """How a simulation before and after agrees with its recording.

    Attributes:
        run: Its name.
        before: Root mean square of the difference in torque, shape (n,) [N m].
        after: The same with what was found.
        left_out: Effects that were found and that the simulation does not have.
        samples: What it was made of; None if that was not kept.
    """

    run: str
    before: np.ndarray
    after: np.ndarray
    left_out: tuple[str, ...]
    samples: Forward | None = None


@dataclass(frozen=True, eq=False)
class PageData:
    """All that pages write and draw of a diagnosis; see `Diagnosis` for what is not explained here.

    Attributes:
        verdict: Sentences, the most important first.
        misfit: Where it goes; None for a diagnosis without.
        undecided: What is there and has no certain name.
        units: Of each joint's torque.
        over_noise: Whether noise was measured at rest, so that numbers may be given as multiples of it.
        noise: Noise floor of each joint's torque behind the filter, shape (n,) [N m]; empty if not known.
        traces: Runs held out first; none if the samples were not kept.
        simulated: None if nothing was simulated.
    """

    name: str
    joints: tuple[str, ...]
    verdict: tuple[str, ...]
    misfit: Misfit | None
    findings: tuple[Named, ...]
    undecided: tuple[Named, ...]
    remainders: tuple[Left, ...]
    moments: tuple[Moment, ...]
    changes: tuple[Change, ...]
    units: tuple[str, ...]
    over_noise: bool
    improvement: Improvement | None
    runs: tuple[str, ...]
    warnings: tuple[str, ...]
    seconds: float
    noise: np.ndarray
    traces: tuple[Trace, ...]
    simulated: Simulated | None

    def clearest_joint(self, finding: Named) -> int:
        """The joint on which the finding is seen best: of those that feel it, where most was gained."""
        found = self.improvement
        if found is None:
            return int(np.argmax(finding.torque))
        gained = (found.before - found.after) / found.noise
        return int(np.argmax(np.where(finding.torque > 0.0, gained, -np.inf)))

    @property
    def judged(self) -> tuple[Trace, ...]:
        """Runs held out, or else all."""
        return tuple(trace for trace in self.traces if trace.role == "validate") or self.traces


def whole(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> dict[str, Any]:
    """All of a diagnosis but its samples, for diagnosis.json.

    Args:
        diagnosis: What was found.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    table = plain(diagnosis) | {"verdict": verdict(diagnosis, folder)}
    if forward is None:
        return table
    return table | {
        "simulated": {
            "run": forward.run,
            # A simulation that diverges has none.
            "torque_rms_before": numbers(forward.before),
            "torque_rms_after": numbers(forward.after),
            "left_out": list(forward.left_out),
        }
    }


def page_data(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> PageData:
    """A diagnosis that was made just now."""
    known = diagnosis.evidence
    found = from_table(whole(diagnosis, forward, folder), known.traces if known else (), forward)
    return found if known is None else replace(found, noise=known.noise)


def from_table(
    table: Mapping[str, Any], traces: Sequence[Trace] = (), forward: Forward | None = None
) -> PageData:
    """A diagnosis from what `whole` makes of it, or from a file of the schema `DiagnosisFile`."""
    noise = array_of(table["noise"] or [])
    simulated = table.get("simulated")
    return PageData(
        name=table["name"],
        joints=tuple(table["joints"]),
        verdict=tuple(table["verdict"]),
        misfit=misfit_of(budget, table["joints"]) if (budget := table.get("budget")) else None,
        findings=tuple(_named(finding, table) for finding in table["findings"]),
        undecided=tuple(_named(finding, table, certain=False) for finding in table.get("undecided", ())),
        remainders=tuple(_left(one) for one in table["remainders"]),
        moments=moments_of(table.get("moments", ())),
        changes=changes_of(table.get("changes", ())),
        units=tuple(table.get("torque_units", [TURNING] * len(table["joints"]))),
        over_noise=bool(table.get("noise_measured_at_rest", True)),
        improvement=_improvement(table, noise) if len(noise) else None,
        runs=tuple(table["runs"]),
        # Older files call the warnings "doubts".
        warnings=tuple(table["warnings"] if "warnings" in table else table["doubts"]),
        seconds=float(table["seconds"]),
        noise=noise,
        traces=tuple(traces),
        simulated=None if simulated is None else _simulated(simulated, forward),
    )


def _left(one: Mapping[str, Any]) -> Left:
    """Of a remainder; older files give it over noise only."""
    size = one.get("left") or f"{value_of(one['over_noise']):.2f} x noise"
    return Left(one["joint"] - 1, float(one["probability"]), one["depends_on"], size)


def _named(finding: Mapping[str, Any], table: Mapping[str, Any], certain: bool = True) -> Named:
    joints = tuple(joint - 1 for joint in finding["joints"])
    name = named(finding["effect"], joints, table["joints"])
    return Named(
        effect=finding["effect"],
        joints=joints,
        name=name,
        headline=_line(table, finding["sentence"] + "." * certain),
        certainty=_line(table, f"{name}: ") if certain else "",
        parameters={
            key: Quantity(value_of(one["value"]), value_of(one["std"]), one["unit"])
            for key, one in finding["parameters"].items()
        },
        probability=float(finding["probability"]),
        alternatives=tuple(
            Alternative(one["effect"], tuple(j - 1 for j in one["joints"]), value_of(one["probability"]))
            for one in finding["alternatives"]
        ),
        torque=array_of(finding["torque_rms"]),
        held_out=value_of(finding["held_out"]),
    )


def _line(table: Mapping[str, Any], beginning: str) -> str:
    """The line of the verdict that begins so, or the beginning."""
    return next((line for line in table["verdict"] if line.startswith(beginning)), beginning)


def _improvement(table: Mapping[str, Any], noise: np.ndarray) -> Improvement:
    before, after = (array_of(table[f"torque_rms_{which}"]) for which in ("before", "after"))
    return Improvement(tuple(table["held_out"]), before, after, noise, float(table["torque_rms_filter_hz"]))


def _simulated(table: Mapping[str, Any], forward: Forward | None) -> Simulated:
    before, after = (array_of(table[f"torque_rms_{which}"]) for which in ("before", "after"))
    return Simulated(table["run"], before, after, tuple(table["left_out"]), forward)
