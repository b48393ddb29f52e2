"""From a log and a URDF to a fit, with nothing stated but what `exidyn init` proposes.

Every public data set, one run of each (`init` looks at all runs, unless --quick), and files written by other
people's libraries, from runs whose units are known. A guess is wrong if it was written down and is not true:
units, columns and their order, whether an effort is the joint's torque, a gain by more than a factor of two
or of the wrong sign. What init leaves open is no guess, and counted apart. Contradictions: numbers that text,
page, JSON and robot.toml of one fit give under one name, and that differ.

Thirty mistakes in a recording that is right without them (--quick: every third): whether init, import and
identify name the cure, and whether a fit is printed as if nothing were wrong. Overstated: guesses of more
than 99 % that are not true, mistakes that are suspected of a log that is right among them.
"""

import contextlib
import io
import json
import os
import shlex
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from common import options, save, show
from parts.own_logs.contradictions import contradictions, in_fit, in_page, in_robot, in_text
from parts.own_logs.foreign import foreign
from parts.own_logs.logs import Known, Log, public
from parts.own_logs.mistakes import MISTAKES, walk_mistake

from exidyn.acquire.command_line import main as exidyn
from exidyn.identify.robot_files.robot_file import read_model

FACTOR = 2.0
"""A rough size of a gain is wrong if it is off by more."""


def run(*arguments: Any) -> tuple[int, str, str]:
    """One command: exit code, standard output, standard error."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = exidyn([str(argument) for argument in arguments])
        except SystemExit as end:
            code = int(end.code or 0)
    return code, out.getvalue(), err.getvalue()


OVERSTATED = 0.99
"""Probability from which on a guess that is not true counts as overstated, written down or not."""


def overstated(found: dict[str, Any], faults: list[str]) -> int:
    """Guesses that are not true and were given more than 99 %."""
    sure = [guess["what"] for guess in found["guesses"] if guess["probability"] > OVERSTATED]
    return sum(any(fault.startswith(what) for what in sure) for fault in faults)


def wrong(found: dict[str, Any], known: Known) -> list[str]:
    """Guesses that were written down and are not true."""
    decided = {guess["what"] for guess in found["guesses"] if guess["decided"]}
    faults = []
    for part in ("time", "position", "velocity"):
        unit, truth = found["units"][part], getattr(known, part)
        if f"unit of {part}" in decided and unit != truth and truth:
            faults.append(f"unit of {part} {unit}, is {truth}")
    undecided = {guess["what"] for guess in found["guesses"] if not guess["decided"]}
    for signal, names in known.columns.items():
        same = found["columns"].get(signal) == names
        if not same and not undecided & {signal, "order of joints", f"unit of {signal}"}:
            faults.append(f"{signal} {found['columns'].get(signal)}, is {names}")
    for place, gain in enumerate(found["gains"]):
        if gain["known"] and known.gain is not None:
            ratio = gain["value"] / known.gain[place]
            if not 1 / FACTOR <= ratio <= FACTOR:
                faults.append(f"gain of joint {place + 1} {gain['value']:.3g}, is {known.gain[place]:.3g}")
    return faults


def walk(log: Log, folder: Path) -> dict[str, Any]:
    """The way of one log; what went wrong is text."""
    path, arm, known = log.make(folder)
    begin = time.perf_counter()
    figures: dict[str, Any] = {"log": log.name, "imported": False, "wrong": [], "open": [], "failed": ""}
    code, _, error = run(
        "init", path, "--urdf", arm, "-o", folder / "robot.toml", "--json", folder / "init.json"
    )
    if code:
        return figures | {"failed": f"init: {error.strip()}", "minutes": 0.0}
    found = json.loads((folder / "init.json").read_text())
    figures["wrong"] = wrong(found, known)
    figures["overstated"] = overstated(found, figures["wrong"])
    figures["open"] = [guess["what"] for guess in found["guesses"] if not guess["decided"]]
    if not log.fit:
        return figures | {"minutes": (time.perf_counter() - begin) / 60}
    figures |= fitted(found["then"], folder)
    return figures | {"minutes": (time.perf_counter() - begin) / 60}


def fitted(then: str, folder: Path) -> dict[str, Any]:
    """Import as proposed, identify, export; and the numbers that are said twice."""
    if not then:
        return {"failed": "init did not decide enough"}
    words = shlex.split(then)[1:]
    code, _, error = run(*words, "-o", folder / "run.mcap")
    if code:
        return {"failed": f"import: {error.strip()}"}
    fit = folder / "fit"
    code, text, error = run("identify", folder / "run.mcap", "-o", fit)
    if code:
        certain = "--as-recorded" in error
        return {"imported": True, "failed": f"identify: {error.strip()}", "suspected": int(certain)}
    table = json.loads((fit / "fit.json").read_text())
    said = [*in_text(text), *in_page((fit / "report.html").read_text()), *in_fit(table)]
    code, _, error = run("export", fit / "fit.json", "--to", "toml", "-o", folder / "identified.toml")
    if not code:
        said += in_robot(read_model(folder / "identified.toml"), table)
    faults, compared = contradictions(said)
    relative = np.median(table["agreement"][0]["relative"])
    return {
        "imported": True,
        "residual": relative,
        "contradicting": faults,
        "compared": compared,
        "exported": not code,
        "not_exported": error.strip() if code else "",
    }


def walk_mistakes(every: bool) -> list[dict[str, Any]]:
    """All mistakes, or every third."""
    rows = []
    for mistake in MISTAKES[:: 1 if every else 3]:
        with tempfile.TemporaryDirectory() as folder:
            rows.append(walk_mistake(mistake, run, Path(folder)))
    head = ["mistake", "cure named", "physics blamed"]
    words = {True: "yes", False: "no"}
    table = [[one["mistake"], words[one["named"]], words[one["physics_blamed"]]] for one in rows]
    show("Mistakes in a log, as init, import and identify see them", head, table)
    return rows


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    logs = [*public(every=not chosen.quick), *foreign()]
    if not any("/" in log.name for log in logs):
        print("no public recordings; set EXIDYN_DATA to their folder")
    done = []
    for log in logs:
        with tempfile.TemporaryDirectory() as folder:
            done.append(walk(log, Path(folder)))
            print(f"{log.name}: {done[-1]['failed'] or 'done'}", flush=True)
    ways = [one for one, log in zip(done, logs, strict=True) if log.fit]
    rows = [
        [
            one["log"],
            "yes" if one["imported"] else "NO",
            len(one["wrong"]),
            len(one["open"]),
            100 * one.get("residual", np.nan),
            len(one.get("contradicting", [])),
            one.get("compared", 0),
            one["minutes"],
        ]
        for one in ways
    ]
    head = ["log", "imported", "wrong", "open", "residual %", "contradictions", "of numbers", "minutes"]
    show("From file and URDF to a fit, as init proposes", head, rows)
    for one in done:
        for fault in (*one["wrong"], *one.get("contradicting", [])[:3], *filter(None, [one["failed"]])):
            print(f"  {one['log']}: {fault}")
    mistakes = walk_mistakes(every=not chosen.quick)
    figures = {
        "named_cure": sum(one["named"] for one in mistakes),
        "of_mistakes": len(mistakes),
        "physics_blamed": sum(one["physics_blamed"] for one in mistakes),
        "overstated": sum(one.get("overstated", 0) + one.get("suspected", 0) for one in done),
        "mistakes": mistakes,
        "imported": sum(one["imported"] for one in ways),
        "of": len(ways),
        "looked_at": len(done),
        "wrong_guesses": sum(len(one["wrong"]) for one in done),
        "contradictions": sum(len(one.get("contradicting", [])) for one in ways),
        "compared": sum(one.get("compared", 0) for one in ways),
        "minutes": {one["log"]: one["minutes"] for one in ways},
        "logs": done,
    }
    said = ("named_cure", "of_mistakes", "physics_blamed", "overstated", "imported", "of", "looked_at")
    print({key: figures[key] for key in (*said, "wrong_guesses", "contradictions")})
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
