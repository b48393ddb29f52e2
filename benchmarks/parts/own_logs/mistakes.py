"""Thirty mistakes that people make with their logs, each in a recording that is right without it.

A mistake's cure is named if what init, import and identify print says one of its words. Physics is blamed if
the cure is not named and a fit is printed all the same.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identify.robot_files.robot_text import urdf_text

from .logs import simulated

Columns = dict[str, np.ndarray]
Run = Callable[..., tuple[int, str, str]]
EVERY = 5
"""Samples of the simulated run, 500 Hz, of which one is written."""


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    Attributes:
        name: In the table.
        make: Changes the columns of a right log.
        says: Pattern of what names the cure.
        robot: Robot that is given in place of the right one.
        options: Further options of import.
    """

    name: str
    make: Callable[[Columns], Columns]
    says: str
    robot: str = "cobot"
    options: tuple[str, ...] = ()


def right_log() -> Columns:
    """Time, positions, velocities and currents of the simulated cobot."""
    run = simulated()
    time, position = run.time[::EVERY], run.position[::EVERY]
    velocity = np.gradient(run.position, run.time, axis=0)[::EVERY]
    columns: Columns = {"t": time}
    for name, values in (("q", position), ("dq", velocity), ("i", run.effort[::EVERY])):
        columns |= {f"{name}{j + 1}": values[:, j].copy() for j in range(values.shape[1])}
    return columns


def _exchanged(*pairs: tuple[str, str]) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        changed = dict(columns)
        for a, b in pairs:
            changed[a], changed[b] = columns[b], columns[a]
        return changed

    return make


def _times(factor: float, *names: str) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        matched = [name for name in columns if any(re.fullmatch(one, name) for one in names)]
        return columns | {name: columns[name] * factor for name in matched}

    return make


def _each(change: Callable[[np.ndarray], np.ndarray], *names: str) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        matched = [name for name in columns if any(re.fullmatch(one, name) for one in names)]
        return columns | {name: change(columns[name]) for name in matched}

    return make


def _register(bits: int) -> Callable[[np.ndarray], np.ndarray]:
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
    return _each(lambda values: np.repeat(values[::times], times)[: len(values)], *names)


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


def _without(signal: str) -> Callable[[Columns], Columns]:
    return lambda columns: {
        name: values for name, values in columns.items() if not re.fullmatch(signal, name)
    }


MISTAKES = (
    Mistake("positions of joints 1 and 2 exchanged", _exchanged(("q1", "q2")), "exchanged"),
    Mistake(
        "columns of joints 1 and 2 exchanged",
        _exchanged(("q1", "q2"), ("i1", "i2"), ("dq1", "dq2")),
        "exchanged",
    ),
    Mistake("currents of joints 2 and 3 exchanged", _exchanged(("i2", "i3")), "exchanged"),
    Mistake(
        "columns of joints 4 and 6 exchanged",
        _exchanged(("q4", "q6"), ("i4", "i6"), ("dq4", "dq6")),
        "exchanged",
    ),
    Mistake("joints in reverse order", _reversed, "reverse order"),
    Mistake("joints one late", _late, "begin one (late|early)"),
    Mistake("current of joint 1 negated", _times(-1.0, "i1"), "joint1 counts against"),
    Mistake("current of joint 2 negated", _times(-1.0, "i2"), "joint2 counts against"),
    Mistake("current of joint 3 negated", _times(-1.0, "i3"), "joint3 counts against"),
    Mistake("all currents negated", _times(-1.0, r"i\d"), "counts? against"),
    Mistake("position of joint 2 negated", _times(-1.0, "q2", "dq2"), "joint2 counts"),
    Mistake("position of joint 3 negated", _times(-1.0, "q3", "dq3"), "joint3 counts"),
    Mistake("currents in mA", _times(1000.0, r"i\d"), "mA"),
    Mistake("current of joint 3 in mA", _times(1000.0, "i3"), "mA"),
    Mistake(
        "currents in per cent", _times(100.0 / 20.0, r"i\d"), "per cent|unit that is not known|in a unit"
    ),
    Mistake("positions in degrees", _times(180 / np.pi, r"q\d"), "degrees|deg "),
    Mistake("position of joint 3 in degrees", _times(180 / np.pi, "q3"), "joint3.*(degrees|deg )"),
    Mistake("radians taken for degrees", _times(1.0), "without (--)?degrees|radians", options=("--degrees",)),
    Mistake("milliseconds", _times(1000.0, "t"), "time-scale|ms "),
    Mistake("positions in counts", _each(_counted(65536), r"q\d"), "counts|ticks|steps of"),
    Mistake("joints 1 and 2 from 0 to 360 degrees", _turned, "full turn"),
    Mistake("currents of 16 bits without sign", _each(_register(16), r"i\d"), "sign"),
    Mistake("current of joint 2, sign in bit 10", _each(_sign_bit(10), "i2"), "sign"),
    Mistake("another robot", _times(1.0), "another (arm|robot)", robot="kr270"),
    Mistake("one stamp twice", _same_stamp, "time does not increase|not increase"),
    Mistake("two publishers", _two_sources, "two (sources|publishers)"),
    Mistake("every sample ten times", _held(10, r"d?q\d", r"i\d"), "repeat"),
    Mistake("velocities in degrees a second", _times(180 / np.pi, r"dq\d"), "velocit.*(deg|derivative)"),
    Mistake("velocity of joint 2 is that of joint 4", _exchanged(("dq2", "dq4")), "velocit.*derivative"),
    Mistake("no positions", _without(r"q\d"), "position"),
)


def walk_mistake(mistake: Mistake, run: Run, folder: Path) -> dict[str, Any]:
    """init, import and identify with a mistake: whether its cure was named, and physics blamed."""
    log = folder / "log.csv"
    columns = mistake.make(right_log())
    text = np.column_stack(list(columns.values()))
    np.savetxt(log, text, "%.9g", ",", header=",".join(columns), comments="")
    (folder / "arm.urdf").write_text(
        simulated().robot if mistake.robot == "cobot" else urdf_of(mistake.robot)
    )
    said = run(
        "init",
        log,
        "--urdf",
        folder / "arm.urdf",
        "-o",
        folder / "robot.toml",
        "--preset",
        folder / "other.toml",
    )
    imported = run("import", log, "--robot", mistake.robot, "-o", folder / "run.mcap", *mistake.options)
    fitted = (2, "", "")
    if imported[0] == 0:
        fitted = run("identify", folder / "run.mcap", "-o", folder / "fit")
    every = {"init": said, "import": imported, "identify": fitted}
    named = [step for step, (_, out, err) in every.items() if re.search(mistake.says, f"{out}\n{err}", re.I)]
    at_fit = [step for step in named if step != "init"]
    return {
        "mistake": mistake.name,
        "named_by": named,
        "named": bool(at_fit),
        "physics_blamed": fitted[0] == 0 and not at_fit,
        "exit": [code for code, _, _ in every.values()],
        "said": imported[2][-300:] if imported[0] else (imported[2] + fitted[2])[-400:],
        "init_said": (said[1] + said[2])[-900:],
    }


def urdf_of(name: str) -> str:
    """A built-in robot as a URDF."""
    from exidyn.identify.robot_files.robot_file import read_model

    return urdf_text(read_model(name))
