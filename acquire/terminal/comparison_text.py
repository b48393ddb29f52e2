"""A comparison of two recordings as a page of text, and as plain tables."""

from typing import Any

import numpy as np

from exidyn.identify.fit.verdict import MISSING
from exidyn.identify.simulation.comparison import NAMES, Comparison, Mismatch, Regions
from exidyn.identify.text_table import WIDTH, at_point, digits, paragraph, table

MOST = 1.5
"""Ratio of a mismatch in its worst third to that in its best from which on it is reported to depend on
something: more than between thirds of a run in which it is the same everywhere."""
ANOTHER = 0.1
"""Share of the motion by which positions differ in another one; the slowest position loops lag by less."""
SMALL = {"rad": "mrad", "m": "mm", "rad/s": "mrad/s", "m/s": "mm/s"}
"""Unit -> its thousandth, in which an arm misses a motion."""


def comparison_text(comparison: Comparison) -> str:
    """One page: what differs most, by joint, by region; a line or three where there is nothing to see."""
    if two_motions(comparison):
        return verdict(comparison)[0]
    if not differs(comparison):
        return "\n".join([*_alike(comparison), *map(_sentence, comparison.warnings)])
    title = f"{comparison.simulated} beside {comparison.recorded}"
    bullets = [line for one in verdict(comparison) for line in paragraph(one, "  ", "- ")]
    parts = [[title.center(WIDTH).rstrip(), "=" * WIDTH, *bullets]]
    parts.append(["Mismatch by joint, root mean square", "-" * WIDTH, *_by_joint(comparison)])
    for mismatch in comparison.mismatches:
        name = f"Mismatch of {mismatch.quantity}{_unit(mismatch)} by region, a third of the samples each"
        parts.append([name, "-" * WIDTH, *_by_region(comparison, mismatch)])
    return "\n\n".join("\n".join(part) for part in parts) + "\n" + "=" * WIDTH


def differs(comparison: Comparison) -> bool:
    """Whether any joint differs by more than noise, in the same motion."""
    return bool(np.any(_over(comparison) > MISSING)) and not two_motions(comparison)


def two_motions(comparison: Comparison) -> bool:
    """Whether both did other things, so that there is nothing to compare."""
    position = comparison.mismatches[0]
    return bool(np.linalg.norm(position.rms) > ANOTHER * np.linalg.norm(position.size))


def _over(comparison: Comparison) -> np.ndarray:
    """Mismatch of the effort over noise, shape (n,)."""
    return comparison.effort.rms / comparison.effort.noise


def _alike(comparison: Comparison) -> list[str]:
    """Three lines about two runs that do not differ."""
    over = np.nan_to_num(_over(comparison))
    most = int(np.argmax(over))
    return [
        f"No joint's {comparison.effort.quantity} differs by more than noise: {comparison.simulated} beside "
        f"{comparison.recorded}",
        f"The largest: {comparison.joints[most]}, {over[most]:.3g} x noise; there is nothing to diagnose",
        _compared(comparison),
    ]


def _compared(comparison: Comparison) -> str:
    """How both were brought together; an offset of less than its last digit has no sign."""
    return (
        f"Compared over {comparison.duration:.1f} s behind a low-pass of {comparison.cutoff:.3g} Hz, "
        f"{comparison.simulated} moved by {round(comparison.offset, 4) + 0.0:.4f} s"
    )


def _sentence(warning: str) -> str:
    return f"{warning[:1].upper()}{warning[1:]}."


def verdict(comparison: Comparison) -> list[str]:
    """What differs most, and what should be known of the comparison, in sentences."""
    effort, over = comparison.effort, _over(comparison)
    if two_motions(comparison):
        position = comparison.mismatches[0]
        most = int(np.argmax(position.rms))
        return [
            f"{comparison.simulated} and {comparison.recorded} are two different motions: "
            f"{comparison.joints[most]} is {digits(position.rms[most])} {position.units[most]} elsewhere."
        ]
    lines = []
    for joint in np.argsort(-np.nan_to_num(over)):
        if over[joint] > MISSING:
            lines.append(_joint(comparison, effort, int(joint)))
    if not lines and not np.any(np.isfinite(over)):
        most = int(np.argmax(effort.rms / effort.size))
        lines = [
            f"The noise is not known, so that {effort.quantity} is not judged. It differs most on "
            f"{comparison.joints[most]}, by {100 * effort.rms[most] / effort.size[most]:.3g} % of what it is."
        ]
    if not lines:
        lines = [f"No joint's {effort.quantity} differs by more than noise: there is nothing to diagnose."]
    lines.append(
        f"{_compared(comparison)}. {effort.quantity.capitalize()} counts while the joint moves, not at rest."
    )
    return [*lines, *map(_sentence, comparison.warnings)]


def _joint(comparison: Comparison, effort: Mismatch, joint: int) -> str:
    share = 100.0 * effort.rms[joint] / effort.size[joint]
    text = (
        f"{comparison.joints[joint]}: {effort.quantity} differs by {digits(effort.rms[joint])} "
        f"{effort.units[joint]}, {share:.3g} % of what it is and "
        f"{effort.rms[joint] / effort.noise[joint]:.3g} x noise"
    )
    kind, ratio, most, least = max(
        ((name, *_contrast(regions, joint)) for name, regions in effort.regions.items()),
        key=lambda found: found[1],
    )
    if ratio < MOST:
        return f"{text}, everywhere alike."
    where = f"{NAMES[most]} {kind} ({_span(comparison, kind, joint, most)})"
    return f"{text}; {ratio:.2g} times as much at {where} as at {NAMES[least]}."


def _contrast(regions: Regions, joint: int) -> tuple[float, int, int]:
    """Mismatch in the worst third over that in the best, and which they are."""
    rms = regions.rms[joint]
    if not np.all(np.isfinite(rms)) or np.min(rms) <= 0.0:
        return 0.0, 0, 0
    most, least = int(np.argmax(rms)), int(np.argmin(rms))
    return float(rms[most] / rms[least]), most, least


def _span(comparison: Comparison, kind: str, joint: int, third: int) -> str:
    """From where to where a third goes."""
    position, velocity, effort = comparison.mismatches
    unit = {"position": position, "speed": velocity, "load": effort}[kind].units[joint]
    low, high = effort.regions[kind].edges[joint, third : third + 2]
    return f"{digits(low)} to {digits(high)} {unit}"


def _unit(mismatch: Mismatch) -> str:
    """The units that people use, in brackets."""
    return f" [{', '.join(dict.fromkeys(SMALL.get(unit, unit) for unit in mismatch.units))}]"


def _scaled(mismatch: Mismatch, values: np.ndarray) -> list[str]:
    """Numbers of all joints in the units that people use."""
    scale = np.array([1e3 if unit in SMALL else 1.0 for unit in mismatch.units])
    return at_point([digits(value) for value in scale * values])


def _by_joint(comparison: Comparison) -> list[str]:
    effort = comparison.effort
    head, columns = ["joint"], [list(comparison.joints)]
    for mismatch in comparison.mismatches:
        head.append(mismatch.quantity + _unit(mismatch))
        columns.append(_scaled(mismatch, mismatch.rms))
    for name, values in (
        ("mean", effort.mean),
        ("% of recorded", 100.0 * effort.rms / effort.size),
        ("over noise", effort.rms / effort.noise),
    ):
        head.append(f"{effort.quantity} {name}" if name == "mean" else name)
        columns.append(at_point([digits(value) for value in values]))
    return table(head, [list(row) for row in zip(*columns, strict=True)])


def _by_region(comparison: Comparison, mismatch: Mismatch) -> list[str]:
    head, columns = ["joint"], [list(comparison.joints)]
    for kind, regions in mismatch.regions.items():
        for third, name in enumerate(NAMES):
            head.append(f"{kind} {name}")
            columns.append(_scaled(mismatch, regions.rms[:, third]))
    return table(head, [list(row) for row in zip(*columns, strict=True)])


def comparison_table(comparison: Comparison, go_on: list[str]) -> dict[str, Any]:
    """The same in numbers, for JSON; what is no number is null.

    Args:
        comparison: What was found.
        go_on: Commands that go on from here.
    """
    return {
        "exidyn_comparison": 1,
        "simulated": comparison.simulated,
        "recorded": comparison.recorded,
        "joints": list(comparison.joints),
        "offset": comparison.offset,
        "duration": comparison.duration,
        "filter_hz": comparison.cutoff,
        "mismatch": {one.quantity: _numbers(one) for one in comparison.mismatches},
        "verdict": verdict(comparison),
        "go_on": go_on,
    }


def _numbers(mismatch: Mismatch) -> dict[str, Any]:
    return {
        "units": list(mismatch.units),
        **{name: _plain(getattr(mismatch, name)) for name in ("rms", "mean", "size", "noise")},
        "regions": {
            kind: {"edges": _plain(regions.edges), "rms": _plain(regions.rms)}
            for kind, regions in mismatch.regions.items()
        },
    }


def _plain(values: np.ndarray) -> list:
    if values.ndim > 1:
        return [_plain(row) for row in values]
    return [float(value) if np.isfinite(value) else None for value in values]
