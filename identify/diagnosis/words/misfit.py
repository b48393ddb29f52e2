"""Misfit: the budget of a diagnosis with names and units, as tables, sentences and files have it."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...text_table import digits, paragraph, table
from ..findings.finding import Diagnosis
from ..results.budget import NOISE, OTHER
from .measures import noise_measured, torque_units
from .naming import effect_words, joined, joint_words, lower, named
from .numbers import array_of, numbers
from .undecided_words import possible

SMALL = 0.01
"""Share of the misfit below which a kind is put together with others, where it is that on every joint."""
LUMPED = "other kinds, less than 1 % each"
CONTAINED = f'Sensor noise was not measured at rest: it is part of "{OTHER}".'
MOST = 3
"""Parts that a sentence names; the table has them all."""


class Part(NamedTuple):
    """One part of the misfit.

    Attributes:
        name: In words.
        effect: The same without its joint; empty for what is no finding.
        joints: Where it acts, from 0.
        place: Of the finding, undecided ones behind the others; None for what is no finding.
        shares: Of the power on each joint, shape (n,) [-].
    """

    name: str
    effect: str
    joints: tuple[int, ...]
    place: int | None
    shares: np.ndarray


class Misfit(NamedTuple):
    """Where the misfit of the nominal model goes.

    Attributes:
        joints: In words.
        units: Of each joint's torque.
        before: Of the model without any finding, root mean square, shape (n,).
        after: With all findings, likewise.
        parts: Findings, kinds by size, noise, and what depends on nothing; they add to one on every joint.
        held_out: Runs that it is of; none where it is of fitted runs whose blocks were left out in turn.
        noise_measured: Whether sensor noise was measured at rest.
    """

    joints: tuple[str, ...]
    units: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray
    parts: tuple[Part, ...]
    held_out: tuple[str, ...]
    noise_measured: bool

    @property
    def source(self) -> str:
        """Which data it is of."""
        if self.held_out:
            return f"held out: {', '.join(self.held_out)}"
        return "of the fitted runs, each block predicted by the others"


def misfit(diagnosis: Diagnosis) -> Misfit | None:
    """The budget with names; None for a diagnosis without."""
    budget = diagnosis.budget
    if budget is None:
        return None
    every = (*diagnosis.findings, *diagnosis.undecided)
    parts = []
    for share in budget.shares:
        if share.finding is None:
            parts.append(Part(_kind(share.kind), "", (), None, share.shares))
            continue
        finding, open_ = every[share.finding], share.finding >= len(diagnosis.findings)
        shown = possible(finding)[0] if open_ else finding
        name, effect = named(shown.effect, shown.joints, diagnosis.joints), effect_words(shown.effect)
        mark = " (name undecided)" if open_ else ""
        parts.append(Part(name + mark, effect + mark, shown.joints, share.finding, share.shares))
    held_out = diagnosis.improvement.runs if diagnosis.improvement and budget.held_out else ()
    measured = noise_measured(diagnosis)
    return Misfit(
        tuple(joint_words(joint, diagnosis.joints) for joint in range(len(diagnosis.joints))),
        torque_units(diagnosis),
        budget.before,
        budget.after,
        tuple(sorted((one for one in parts if measured or one.name != NOISE), key=_order)),
        held_out,
        measured,
    )


def _order(part: Part) -> tuple[int, float]:
    """Findings as they are, kinds by size, then noise and what depends on nothing."""
    if part.place is not None:
        return 0, float(part.place)
    last = {NOISE: 2, OTHER: 3}
    return last.get(part.name, 1), -float(np.max(part.shares, initial=0.0))


def _kind(kind: str) -> str:
    return kind if kind in (NOISE, OTHER) else f"depends on {kind}"


def lumped(found: Misfit) -> Misfit:
    """The same with small kinds in one part."""
    small = [one for one in found.parts if _small(one)]
    if len(small) < 2:
        return found
    sums = sum((one.shares for one in small), np.zeros(len(found.joints)))
    kept = [one for one in found.parts if not _small(one)]
    whole = Part(LUMPED, "", (), None, sums)
    last = [one for one in kept if one.name in (NOISE, OTHER)]
    return found._replace(parts=(*(one for one in kept if one.name not in (NOISE, OTHER)), whole, *last))


def _small(part: Part) -> bool:
    kind = part.place is None and part.name not in (NOISE, OTHER)
    return kind and bool(np.all(part.shares < SMALL))


def percents(shares: np.ndarray) -> np.ndarray:
    """Shares of parts (s, n) as whole per cents that add up to 100 on every joint; 0 where not known.

    What is rounded off goes to the parts that lost most by it.
    """
    exact = 100.0 * np.nan_to_num(shares, posinf=0.0, neginf=0.0)
    whole = np.floor(exact)
    for joint in range(exact.shape[1]):
        lacking = round(float(exact[:, joint].sum())) - int(whole[:, joint].sum())
        first = np.argsort(whole[:, joint] - exact[:, joint], kind="stable")
        whole[first[: max(lacking, 0)], joint] += 1.0
    return whole.astype(int)


def lines(found: Misfit) -> list[str]:
    """The table of the text page, and sentences."""
    short = lumped(found)
    head = ["", *(f"joint {joint + 1}" for joint in range(len(short.joints)))]
    rows = [
        _sizes("misfit before", short.before, short.units),
        _sizes("misfit after", short.after, short.units),
    ]
    rows += [
        [one.name, *(f"{value} %" if value else "-" for value in own)]
        for one, own in zip(short.parts, _whole(short), strict=True)
        if np.any(own)
    ]
    written = [line for one in sentences(found) for line in paragraph(one, "  ", "- ")]
    note = f"Root mean square, {found.source}; parts are shares of its square."
    return [
        *table(head, rows),
        *paragraph(note),
        *([] if found.noise_measured else [CONTAINED]),
        *written,
    ]


def _sizes(name: str, values: np.ndarray, units: Sequence[str]) -> list[str]:
    """A row with one unit at its head, or one in each cell."""
    if len(set(units)) == 1:
        return [f"{name} [{units[0]}]", *map(digits, values)]
    return [name, *(f"{digits(value)} {unit}" for value, unit in zip(values, units, strict=True))]


def _whole(found: Misfit) -> np.ndarray:
    return percents(np.array([one.shares for one in found.parts]))


def sentences(found: Misfit) -> list[str]:
    """One for each joint: what explains how much of it, and with what most of the rest goes."""
    short = lumped(found)
    whole = _whole(short)
    return [_joint(short, joint, whole[:, joint]) for joint in range(len(short.joints))]


def _joint(found: Misfit, joint: int, whole: np.ndarray) -> str:
    size = f"{found.before[joint]:.3g} {found.units[joint]}"
    pairs = [(one, int(share)) for one, share in zip(found.parts, whole, strict=True) if share]
    explaining = sorted((pair for pair in pairs if pair[0].place is not None), key=lambda pair: -pair[1])
    rest = [one for one in found.parts if one.place is None and one.shares[joint] > 0.0]
    where = found.joints[joint]
    if not explaining:
        most = _most(rest, joint)
        return f"{where}: no finding explains any of the {size} that the model misses{most}."
    (first, share), *others = explaining[:MOST]
    text = f"{where}: {_here(first, joint)} explains {share} % of the {size} that the model misses"
    if others:
        more = [f"{_here(one, joint)} ({percent} %)" for one, percent in others]
        text += f", besides {joined(more)}"
    return f"{text}{_most(rest, joint, '; of the rest, ')}."


def _here(part: Part, joint: int) -> str:
    """The finding's name, with its joint where that is another."""
    name = part.effect if part.joints == (joint,) or not part.joints else part.name
    return lower(name)


def _most(rest: Sequence[Part], joint: int, opening: str = "; ") -> str:
    total = sum(float(one.shares[joint]) for one in rest)
    if total < SMALL:
        return ""
    largest = max(rest, key=lambda one: float(one.shares[joint]))
    share = float(largest.shares[joint]) / total
    amount = "most" if share > 0.5 else f"the largest part ({100 * share:.0f} %)"
    if largest.name == NOISE:
        return f"{opening}{amount} is {NOISE}"
    # Older files have "goes with".
    known = largest.name.startswith(("depends on", "goes with"))
    kind = largest.name if known else f"depends on {largest.name}"
    return f"{opening}{amount} {kind}"


def as_table(found: Misfit) -> dict[str, Any]:
    """For diagnosis.json: parts in per cent, which add up to 100 on every joint."""
    return {
        "held_out": list(found.held_out),
        "noise_measured_at_rest": found.noise_measured,
        "units": list(found.units),
        "before_rms": numbers(found.before),
        "after_rms": numbers(found.after),
        "shares": [
            {
                "name": one.name,
                "effect": one.effect,
                "joints": [joint + 1 for joint in one.joints],
                "finding": one.place,
                "percent": numbers(100.0 * one.shares),
            }
            for one in found.parts
        ],
    }


def from_table(table: Mapping[str, Any], joints: Sequence[str]) -> Misfit:
    """Read it back, of a table of the schema `DiagnosisFile`."""
    parts = tuple(
        Part(
            one["name"],
            one["effect"],
            tuple(joint - 1 for joint in one["joints"]),
            one["finding"],
            array_of(one["percent"]) / 100.0,
        )
        for one in table["shares"]
    )
    return Misfit(
        tuple(joint_words(joint, joints) for joint in range(len(joints))),
        tuple(table["units"]),
        array_of(table["before_rms"]),
        array_of(table["after_rms"]),
        parts,
        tuple(table["held_out"]),
        bool(table["noise_measured_at_rest"]),
    )
