"""Does the check of a log refuse what is right, claim what is false, or miss what is wrong?

Right recordings: every public set, as a whole, run by run, and in halves. A refusal is false; so is a
suspicion of more than 95 % that the set's README denies. Right logs: from log and URDF to a fit with nothing
stated but what `exidyn init` proposes, for public sets, for files as other people's libraries write them, and
for simulated arms. A guess is false if it is not true: unit, column, order of joints, whether an effort is a
torque of the joint, a gain by more than a factor of two or of the wrong sign.

Mistakes, each in a simulated log that is right without it: whether what init, import, identify or gap print
names the cure, in words that the right log does not get. --quick takes a few of everything; --resume FILE
keeps each case and goes on from there.
"""

import json
import os
import shlex
import tempfile
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from common import Kept, parser, save, show
from parts.own_logs.arms import SCENES
from parts.own_logs.commands import proposal_of, run, run_next, walk_mistake, walk_right
from parts.own_logs.foreign import Log, foreign, public
from parts.own_logs.mistakes import MISTAKES, MORE, in_mujoco
from parts.own_logs.sets import QUICK, SETS, checked
from parts.own_logs.tables import of_init, show_logs, show_mistakes, show_recordings, show_statements, summary

Case = dict[str, Any]
"""Figures of one case, as JSON has them."""


def walk(log: Log, fit: bool) -> Case:
    """Init on one right log, its Next, and where asked the way on to a fit."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path, arm, known = log.make(folder)
        written = ("-o", folder / "robot.toml", "--json", folder / "init.json")
        done = run("init", path, "--robot", arm, *written)
        seconds = {"init": done.seconds}
        figures: Case = {"log": log.name, "seconds": seconds, "failed": "", "refused": []}
        if done.code:
            return figures | {"failed": f"init: {done.err.strip()}", "statements": []}
        proposal = proposal_of(folder / "init.json") or {}
        figures["statements"] = [one._asdict() for one in of_init(log.name, proposal, known)]
        figures["open"] = [guess["what"] for guess in proposal["guesses"] if not guess["decided"]]
        figures["next"] = run_next(proposal, folder / "next")
        if fit and proposal["then"]:
            figures |= fitted(proposal["then"], folder, log.name)
        return figures


def fitted(then: str, folder: Path, name: str) -> Case:
    """Import as proposed, and identify."""
    done = run(*shlex.split(then)[1:], "-o", folder / "run.mcap")
    if done.code:
        return {"failed": f"import: {done.err.strip()}"}
    fit = folder / "fit"
    done = run("identify", folder / "run.mcap", "-o", fit)
    if done.code:
        failed = f"identify: {done.err.strip()}"
        return {"failed": failed, "refused": [f"{name}: {failed}"]}
    table = json.loads((fit / "fit.json").read_text())
    return {"residual": float(np.nanmedian(np.array(table["agreement"][0]["relative"], float)))}


QUICK_MISTAKES = ("currents of joints 2 and 3 exchanged", "currents in mA")
QUICK_LOGS = ("bam_xl330", "emps", "h5py as MATLAB 7.3")
"""With --quick."""


def right_logs(kept: Kept, quick: bool) -> list[Case]:
    """All right logs that are not simulated, one run of each public set."""
    logs = [*public(), *foreign()]
    if not any("/" in log.name for log in logs):
        print("no public recordings; set EXIDYN_DATA to their folder")
    logs = [log for log in logs if log.name.startswith(QUICK_LOGS)] if quick else logs
    return [
        kept.of(f"log {log.name}{' quick' * quick}", lambda log=log: walk(log, not quick)) for log in logs
    ]


def recordings(kept: Kept, quick: bool) -> list[Case]:
    """All public recordings, as a whole, run by run, and in halves."""
    sets = [data for data in SETS if data.path.exists() and (not quick or data.folder in QUICK)]
    return [
        kept.of(f"set {data.name}{' quick' * quick}", lambda data=data: checked(data, quick)) for data in sets
    ]


def mistakes(kept: Kept, quick: bool) -> tuple[list[Case], list[Case]]:
    """Right logs of the simulated arms, and mistakes in them."""
    every = [mistake for mistake in (*MISTAKES, *MORE) if not quick or mistake.name in QUICK_MISTAKES]
    names = {make: name for name, make in SCENES.items()} | {in_mujoco: "servos"}
    used = sorted({names[mistake.scene] for mistake in every} | {"legs"})
    brief = ["legs"] if quick else []  # with --quick only init sees twelve joints
    right = {
        name: kept.of(
            f"right {name}{' quick' * (name in brief)}",
            lambda name=name: walk_right(name, SCENES[name](), name in brief),
        )
        for name in used
    }
    wrong = [
        kept.of(f"mistake {mistake.name}", lambda m=mistake: walk_mistake(m, right[names[m.scene]]["texts"]))
        for mistake in every
    ]
    return list(right.values()), wrong


def main() -> None:
    taken = parser(__doc__.splitlines()[0])
    taken.add_argument("--resume", type=Path, metavar="FILE", help="keep each case in FILE, go on from it")
    chosen = taken.parse_args()
    kept = Kept(chosen.resume)
    right, wrong = mistakes(kept, chosen.quick)
    sets, logs = recordings(kept, chosen.quick), right_logs(kept, chosen.quick)
    show_recordings(sets)
    show_logs([*logs, *right])
    show_mistakes(wrong)
    table = show_statements([*sets, *logs, *right, *wrong])
    figures = summary(sets, logs, right, wrong)
    show("Summary", ["figure", "value"], list(map(list, figures.items())))
    cases = {"sets": sets, "logs": logs, "right": right, "mistakes": wrong}
    save(chosen.json, figures | {"calibration": table, "cases": cases})


if __name__ == "__main__":
    main()
