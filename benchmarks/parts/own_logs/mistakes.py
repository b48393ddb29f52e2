"""Mistakes that people make with their logs, each in a recording that is right without it: the first thirty.

A mistake's cure is named if the words of one of its patterns stand close together in what init, import,
identify or gap print about it, and not in what they print about the right log.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .scenes import Columns, Scene, cobot

Step = tuple[str, ...]
"""Words of one command; {folder}, {log}, {arm} and {robot} in them stand for paths."""
INIT: Step = (
    "init",
    "{log}",
    "--robot",
    "{arm}",
    "-o",
    "{folder}/init/robot.toml",
    "--preset",
    "{folder}/init/preset.toml",
    "--json",
    "{folder}/init/init.json",
)
IMPORT: Step = ("import", "{log}", "--robot", "{robot}", "-o", "{folder}/run.mcap")
IDENTIFY: Step = ("identify", "{folder}/run.mcap", "-o", "{folder}/fit")
WALK = (INIT, IMPORT, IDENTIFY)


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    Attributes:
        name: In the table.
        make: Changes the columns of the right log.
        says: Patterns that must all stand close together in what names the cure.
        scene: The right log.
        robot: Built-in robot, or text of robot.toml, stated in place of the right one.
        options: Further options of import.
        steps: Commands.
        others: Makes further logs by their names, as a second run.
    """

    name: str
    make: Callable[[Columns], Columns]
    says: tuple[str, ...]
    scene: Callable[[], Scene] = cobot
    robot: str = ""
    options: tuple[str, ...] = ()
    steps: tuple[Step, ...] = WALK
    others: dict[str, Callable[[], Columns]] = field(default_factory=dict)


def exchanged(*pairs: tuple[str, str]) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        changed = dict(columns)
        for a, b in pairs:
            changed[a], changed[b] = columns[b], columns[a]
        return changed

    return make


def times(factor: float, *names: str) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        matched = [name for name in columns if any(re.fullmatch(one, name) for one in names)]
        return columns | {name: columns[name] * factor for name in matched}

    return make


def each(change: Callable[[np.ndarray], np.ndarray], *names: str) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        matched = [name for name in columns if any(re.fullmatch(one, name) for one in names)]
        return columns | {name: change(columns[name]) for name in matched}

    return make


def register(bits: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda values: np.round(values * 1000.0) % 2.0**bits / 1000.0


def _sign_bit(bit: int) -> Callable[[np.ndarray], np.ndarray]:
    def change(values: np.ndarray) -> np.ndarray:
        counts = np.round(values * 0.9 * 2**bit / np.abs(values).max())
        scale = np.abs(values).max() / (0.9 * 2**bit)
        return scale * np.where(counts < 0, 2.0**bit - counts, counts)

    return change


def _counted(steps: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda values: np.round(values * steps / (2 * np.pi))


def _rows(change: Callable[[int], np.ndarray]) -> Callable[[Columns], Columns]:
    """The same samples in other rows; change takes their number."""

    def make(columns: Columns) -> Columns:
        rows = change(len(columns["t"]))
        return {name: values[rows] for name, values in columns.items()}

    return make


def _held(times: int, *names: str) -> Callable[[Columns], Columns]:
    return each(lambda values: np.repeat(values[::times], times)[: len(values)], *names)


def _reversed(columns: Columns) -> Columns:
    return columns | {f"{s}{j}": columns[f"{s}{7 - j}"] for s in ("q", "dq", "i") for j in range(1, 7)}


def _late(columns: Columns) -> Columns:
    return columns | {
        f"{s}{j}": columns[f"{s}{(j - 2) % 6 + 1}"] for s in ("q", "dq", "i") for j in range(1, 7)
    }


def _same_stamp(columns: Columns) -> Columns:
    time = columns["t"].copy()
    time[1000] = time[999]
    return columns | {"t": time}


def _two_sources(columns: Columns) -> Columns:
    """Between all rows one of zeros with the same stamp and without effort."""
    mixed = {}
    for name, values in columns.items():
        other = values if name == "t" else np.full(len(values), np.nan if name.startswith("i") else 0.0)
        mixed[name] = np.column_stack([values, other]).ravel()
    return mixed


def _turned(columns: Columns) -> Columns:
    """Joints 1 and 2 to 0 ... 360 degrees; joint 1 passes through zero."""
    return columns | {f"q{j}": np.mod(columns[f"q{j}"], 2 * np.pi) for j in (1, 2)}


def without(signal: str) -> Callable[[Columns], Columns]:
    return lambda columns: {
        name: values for name, values in columns.items() if not re.fullmatch(signal, name)
    }


EXCHANGED = r"exchanged|other way round|interchanged|swapped"
AGAINST = r"against|other way|opposite|negated|reversed|negative|turn"
EFFORT = r"current|effort|torque"
PER_THOUSAND = r"(?-i:\bmA\b)|thousandth|milli|\b1000\b|\b0?\.001\d?\b|1e-0?3"
MISTAKES = (
    Mistake(
        "positions of joints 1 and 2 exchanged",
        exchanged(("q1", "q2")),
        (rf"positions? .*joint1 and joint2.*({EXCHANGED})|position .*column.*q2, ?q1|q2, q1, q3",),
    ),
    Mistake(
        "columns of joints 1 and 2 exchanged",
        exchanged(("q1", "q2"), ("i1", "i2"), ("dq1", "dq2")),
        (rf"joint1 and joint2.*({EXCHANGED})|order of joints +2, 1, 3",),
    ),
    Mistake(
        "currents of joints 2 and 3 exchanged",
        exchanged(("i2", "i3")),
        (rf"(efforts?|currents?) .*joint2 and joint3.*({EXCHANGED})|i1, i3, i2",),
    ),
    Mistake(
        "columns of joints 4 and 6 exchanged",
        exchanged(("q4", "q6"), ("i4", "i6"), ("dq4", "dq6")),
        (rf"joint4 and joint6.*({EXCHANGED})|order of joints +1, 2, 3, 6, 5, 4",),
    ),
    Mistake("joints in reverse order", _reversed, (r"reverse(d)? order|order of joints +6, 5, 4, 3, 2, 1",)),
    Mistake(
        "joints one late",
        _late,
        (r"(begin|start|are|is) one (joint )?(late|early)|order of joints +2, 3, 4, 5, 6, 1",),
    ),
    Mistake("current of joint 1 negated", times(-1.0, "i1"), ("joint1", AGAINST)),
    Mistake(
        "current of joint 2 negated", times(-1.0, "i2"), (rf"joint2\b.{{0,40}}({AGAINST})|gain of joint2 +-",)
    ),
    Mistake(
        "current of joint 3 negated", times(-1.0, "i3"), (rf"joint3\b.{{0,40}}({AGAINST})|gain of joint3 +-",)
    ),
    Mistake(
        "all currents negated", times(-1.0, r"i\d"), (rf"all ({EFFORT})s? .*({AGAINST})|gain of joint2 +-",)
    ),
    Mistake(
        "position of joint 2 negated",
        times(-1.0, "q2", "dq2"),
        (rf"joint2\b.{{0,40}}({AGAINST})|gain of joint2 +-",),
    ),
    Mistake(
        "position of joint 3 negated",
        times(-1.0, "q3", "dq3"),
        (rf"joint3\b.{{0,40}}({AGAINST})|gain of joint3 +-",),
    ),
    Mistake("currents in mA", times(1000.0, r"i\d"), (PER_THOUSAND, EFFORT)),
    Mistake("current of joint 3 in mA", times(1000.0, "i3"), (PER_THOUSAND, "joint3")),
    Mistake(
        "currents in per cent",
        times(100.0 / 20.0, r"i\d"),
        (r"per ?cent|in a unit|unit that is not (known|stated)|off by|factor|times", EFFORT),
    ),
    Mistake("positions in degrees", times(180 / np.pi, r"q\d"), (r"in degrees|position +deg\b|--degrees",)),
    Mistake("position of joint 3 in degrees", times(180 / np.pi, "q3"), ("joint3|q3", r"degrees|\bdeg\b")),
    Mistake(
        "radians taken for degrees",
        times(1.0),
        (r"without (--)?degrees|(are|in) radians",),
        options=("--degrees",),
    ),
    Mistake("milliseconds", times(1000.0, "t"), (r"time-scale|unit of time +ms\b|milliseconds",)),
    Mistake(
        "positions in counts",
        each(_counted(65536), r"q\d"),
        (r"\bin counts|counts of|ticks|steps of (an |the )?encoder|steps a turn",),
    ),
    Mistake("joints 1 and 2 from 0 to 360 degrees", _turned, (r"full turns?|wrap|360", r"q1|joint1")),
    Mistake(
        "currents of 16 bits without sign",
        each(register(16), r"i\d"),
        (r"\bsigns?\b", r"16 bits|65[.,]?536|lost"),
    ),
    Mistake(
        "current of joint 2, sign in bit 10",
        each(_sign_bit(10), "i2"),
        ("sign", r"i2|joint2", r"\bbit|lost|1024"),
    ),
    Mistake(
        "another robot",
        times(1.0),
        (r"another (arm|robot)|(other|different) (arm|robot) than",),
        robot="kr270",
    ),
    Mistake(
        "one stamp twice",
        _same_stamp,
        (r"not increase|same (stamp|time)|repeated? (stamp|time)|stamps? twice",),
    ),
    Mistake("two publishers", _two_sources, (r"two (sources|publishers)",)),
    Mistake(
        "every sample ten times",
        _held(10, r"d?q\d", r"i\d"),
        (r"repeat|same sample|held|ten times|10 times",),
    ),
    Mistake("velocities in degrees a second", times(180 / np.pi, r"dq\d"), ("velocit", r"\bdeg|derivative")),
    Mistake(
        "velocity of joint 2 is that of joint 4",
        exchanged(("dq2", "dq4")),
        ("velocit", "derivative", r"joint2|dq2|joint4|dq4"),
    ),
    Mistake(
        "no positions",
        without(r"q\d"),
        (r"no (column of |columns of )?position|position.{0,60}(not|missing|needed)|q1.*(missing|needed)",),
    ),
)
"""The first thirty."""
