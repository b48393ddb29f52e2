"""Statements with a stated probability, whether they are true of a log, and tables."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from common import show


@dataclass(frozen=True)
class Known:
    """What is true of a log."""

    time: str  # Unit
    position: str  # Unit
    velocity: str  # Unit a second, "" without velocities
    # "torque" of the joints, "current" for anything that needs a gain, "command" where there is none and
    # servos follow commands; "" where nobody knows
    effort: str
    gain: np.ndarray | None  # Of the drives [N m per unit], shape (n,); None where nobody knows
    columns: dict[str, list[str]]  # Names by signal, in the order of the robot's joints
    gravity: bool = True  # Whether the arm is known to stand as it is described


CERTAIN, SURE = 0.95, 0.99
"""Stated probabilities above which a statement counts as certain, and as more than certain."""
FACTOR = 2.0
"""A size of a gain is wrong if it is off by more than this factor."""
TORQUE, AGAINST = "N m of the joint", "N m against the joint"
"""Values of the unit of an effort that need no gain, as init prints them; any other needs a gain."""
EFFORT = ("torque", "current")
"""Names of an effort in a proposal."""
LEANS = 3.0
"""Angle by which a base may lean where its description has it upright [deg]."""
SAME = 2e-3
"""Largest residual of two columns that hold the same numbers in other units, as a share of their spread."""
SHARE = 0.01
"""Largest relative difference of a factor from that of a unit."""
UNITS = {
    "time": {1.0: "s", 1e3: "ms", 1e6: "us", 1e9: "ns"},
    "position": {1.0: "rad", 180 / np.pi: "deg"},
}
"""Signal -> units by their number in an SI unit."""


class Statement(NamedTuple):
    """A sentence that was printed."""

    where: str  # Log and command
    text: str  # What it says
    probability: float  # As stated
    true: bool | None  # Whether it is true; None if nobody knows


def of_init(where: str, proposal: Mapping[str, Any], known: Known) -> list[Statement]:
    """All guesses of init, from its JSON."""
    return [
        Statement(
            where,
            f"{guess['what']}: {guess['value']}",
            guess["probability"],
            judged(guess, proposal, known, where),
        )
        for guess in proposal["guesses"]
    ]


def judged(
    guess: Mapping[str, Any], proposal: Mapping[str, Any], known: Known, where: str = ""
) -> bool | None:
    """Whether a guess of init about a log is true."""
    what, value = guess["what"], guess["value"]
    if what in ("unit of time", "unit of position", "unit of velocity"):
        signal = what.removeprefix("unit of ")
        truth = getattr(known, signal)
        if truth == "?":
            return proposal["units"][signal] not in UNITS[signal].values()
        return proposal["units"][signal] == truth if truth else None
    if what.startswith("unit of "):
        needs_gain = value not in (TORQUE, AGAINST)
        against = known.gain is not None and bool(np.all(known.gain < 0))
        if known.effort == "torque" and not needs_gain:
            return against == (value == AGAINST)
        return needs_gain == (known.effort == "current") if known.effort else None
    if what.startswith("gain of "):
        return _true_gain(guess, proposal, known)
    if what == "order of joints":
        return all(_in_order(_names(proposal, signal), names) for signal, names in known.columns.items())
    if what in ("position", *EFFORT):
        truth = known.columns.get(what if what == "position" else known.effort)
        if truth is not None and " to " in value:  # columns without names
            return bool(value == f"{truth[0]} to {truth[-1]}")
        pattern = re.sub(r"\\\{\w+\\\}", ".+", re.escape(value))  # of q{number}
        return None if truth is None else all(re.fullmatch(pattern, name) for name in truth)
    if what == "direction of gravity":
        if value.startswith("none"):
            return "without gravity" in where if known.gravity else None
        return upright(value) if known.gravity else None
    return None


def upright(value: str) -> bool:
    """Whether a direction, as init prints it, is down, as for all arms of this benchmark."""
    numbers = np.array([float(number) for number in re.findall(r"-?\d+\.\d+", value)[:3]])
    return bool(-numbers[2] / np.linalg.norm(numbers) > np.cos(np.radians(LEANS)))


def _names(proposal: Mapping[str, Any], signal: str) -> list[str]:
    """Columns of a signal as proposed; of an effort under whichever name it goes."""
    signals = EFFORT if signal in EFFORT else (signal,)
    return next((proposal["columns"][name] for name in signals if name in proposal["columns"]), [])


def _in_order(names: Sequence[str], truth: Sequence[str]) -> bool:
    """Whether names are those of the truth; joints that stand still may be left out."""
    return bool(names) and list(names) == [name for name in truth if name in names]


def _true_gain(guess: Mapping[str, Any], proposal: Mapping[str, Any], known: Known) -> bool | None:
    names = [one["what"] for one in proposal["guesses"] if one["what"].startswith("gain of ")]
    places = [place for place, gain in enumerate(proposal["gains"]) if gain["known"]]
    if known.gain is None or guess["what"] not in names[: len(places)]:
        return None
    place = places[names.index(guess["what"])]
    ratio = proposal["gains"][place]["value"] / known.gain[place]
    return None if np.isnan(ratio) else bool(1 / FACTOR <= ratio <= FACTOR)


def altered(known: Known, right: Mapping[str, np.ndarray], log: Mapping[str, np.ndarray]) -> Known:
    """What is true of a log that was made from a right one, by which of its columns hold the same numbers."""
    if any(len(values) != len(right["t"]) for values in log.values()):
        return known
    held = {s: [_holder(right[name], log, name) for name in names] for s, names in known.columns.items()}
    columns = {signal: [name for name, _ in pairs] for signal, pairs in held.items()}
    factors = {signal: np.array([factor for _, factor in pairs]) for signal, pairs in held.items()}
    gain, effort = known.gain, known.effort
    if gain is not None and effort in ("torque", "current"):
        gain = gain / factors[effort] * np.sign(np.nan_to_num(factors["position"], nan=1.0))
        same = np.isfinite(gain)
        kind = effort if not same.any() else "torque" if np.allclose(np.abs(gain[same]), 1.0) else "current"
        columns[kind] = columns.pop(effort)
        effort = kind
    if gain is not None and effort == "command":
        gain = np.where(np.isfinite(factors[effort]), gain, np.nan)
    speeds = [name for name in right if name.startswith("dq")]
    kept = all(name in log and np.array_equal(right[name], log[name]) for name in speeds)
    units = {signal: _unit(signal, factors[signal]) for signal in ("time", "position")}
    if np.isnan(factors["time"]).all():  # stamps moved, and their unit did not
        units["time"] = known.time
    velocity = known.velocity if kept else ""
    return replace(known, columns=columns, gain=gain, effort=effort, velocity=velocity, **units)


def _holder(values: np.ndarray, log: Mapping[str, np.ndarray], name: str) -> tuple[str, float]:
    """Column of a log that has these values (t,) in some unit, and its number per unit; NaN if none has."""
    for column in sorted(log, key=lambda column: column != name):
        factor = float(values @ log[column] / (values @ values)) if values.any() else 0.0
        if factor and np.std(log[column] - factor * values) < SAME * np.std(log[column]):
            return column, factor
    return name, np.nan


def _unit(signal: str, factors: np.ndarray) -> str:
    """Unit of all columns by their numbers per SI unit (n,); "?" if no unit is right for all."""
    sizes = np.abs(factors[np.isfinite(factors)])
    for number, unit in UNITS[signal].items():
        if len(sizes) and np.all(np.abs(sizes / number - 1) < SHARE):
            return unit
    return "?"


def calibration(statements: Sequence[Statement]) -> list[list[Any]]:
    """Rows of a table: band of stated probability, number of statements, true ones, share [%]."""
    rows: list[list[Any]] = []
    for band, least, most in (("95 to 99 %", CERTAIN, SURE), ("> 99 %", SURE, 2.0)):
        judged = [one.true for one in statements if least < one.probability <= most and one.true is not None]
        rows.append([band, len(judged), sum(judged), 100 * np.mean(judged) if judged else np.nan])
    return rows


Case = dict[str, Any]
"""Figures of one case, as JSON has them."""


def statements_of(cases: Sequence[Case]) -> list[Statement]:
    """All statements of some cases."""
    return [Statement(**statement) for case in cases for statement in case["statements"]]


def show_logs(logs: Sequence[Case]) -> None:
    """Tables of the right logs."""
    rows = []
    for case in logs:
        false = [one for one in statements_of([case]) if one.probability > CERTAIN and one.true is False]
        following = {None: "none", "": "works"}.get(case.get("next"), "FAILS")
        numbers = [
            len(false),
            len(case.get("open", [])),
            case.get("residual", np.nan),
            case["seconds"]["init"],
        ]
        rows.append([case["log"], following, *numbers])
    head = ["right log", "Next", "false", "open", "residual", "init CPU s"]
    show("From file and URDF to a fit, as init proposes", head, rows)
    for case in logs:
        following = f"Next: {case['next']}" if case.get("next") else ""
        for fault in filter(None, (case.get("failed"), following)):
            print(f"  {case['log']}: {fault}")


def show_recordings(sets: Sequence[Case]) -> None:
    """Table of the public recordings."""
    rows = []
    for case in sets:
        sure = [one for one in statements_of([case]) if one.probability > CERTAIN]
        verdicts = [one.true for one in sure]
        counts = [verdicts.count(verdict) for verdict in (True, None, False)]
        rows.append([case["set"], case["checked"], len(case["refused"]), *counts])
    head = ["recordings", "checked", "refused", "true > 95 %", "nobody knows", "false > 95 %"]
    show("Public recordings, as a whole, run by run, and in halves", head, rows)


def show_mistakes(cases: Sequence[Case]) -> None:
    """Table of the mistakes."""
    words = {True: "yes", False: "no"}
    rows = []
    for case in cases:
        false = [one for one in statements_of([case]) if one.probability > SURE and one.true is False]
        by = ", ".join(case["named_by"])
        rows.append([case["mistake"], words[case["named"]], by, words[case["physics_blamed"]], len(false)])
    head = ["mistake", "cure named", "by", "physics blamed", "false > 99 %"]
    show("Mistakes in a log", head, rows)
    for case in cases:
        if case.get("next"):
            print(f"  {case['mistake']}: Next: {case['next']}")


def show_statements(cases: Sequence[Case]) -> list[list[Any]]:
    """Table of stated probabilities; what is false of statements and refusals."""
    table = calibration(statements_of(cases))
    show("Statements with a probability, true and false", ["stated", "statements", "true", "true %"], table)
    for one in statements_of(cases):
        if one.probability > CERTAIN and one.true is False:
            print(f"  {one.where}: {one.text} ({100 * one.probability:.1f} %)")
    for case in cases:
        for refusal in case.get("refused", []):
            print(f"  refused: {refusal}")
    return table


def summary(sets: list[Case], logs: list[Case], right: list[Case], wrong: list[Case]) -> Case:
    """The figures of all cases."""
    good, every = [*sets, *logs, *right], [*sets, *logs, *right, *wrong]
    sure = [one for one in statements_of(every) if one.probability > SURE and one.true is not None]
    false = [one for one in statements_of(good) if one.probability > CERTAIN and one.true is False]
    following = [case["next"] for case in every if case.get("next") is not None]
    seconds = {
        case.get("log", case.get("set", case.get("mistake"))): case["seconds"].get("init", 0.0)
        for case in every
    }
    slowest = max(seconds, key=lambda name: seconds[name])
    return {
        "false_refusals": sum(len(case["refused"]) for case in good),
        "false_certain": len(false),
        "named_cure": sum(case["named"] for case in wrong),
        "of_mistakes": len(wrong),
        "physics_blamed": sum(case["physics_blamed"] for case in wrong),
        "certain_true_percent": 100 * float(np.mean([one.true for one in sure])) if sure else None,
        "of_certain": len(sure),
        "next_works": following.count(""),
        "of_next": len(following),
        "init_seconds_worst": seconds[slowest],
        "init_slowest": slowest,
        "init_fails": sum(case.get("failed", "").startswith("init") for case in logs),
        "of_logs": len(logs),
        "checked": sum(case["checked"] for case in sets),
    }
