"""Faults of what a run reads and writes: a corrupt plan, a full disk, a viewer or a recorder that is killed.

Run as a module with a folder on a small file system, it is the run into that folder.
"""

import contextlib
import io
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from common import imports_as_here

from exidyn.acquire import command_line
from exidyn.acquire.run.before import check_plan
from exidyn.acquire.run.pipe import PipeSink, Sink
from exidyn.acquire.run.recorder import part_of
from exidyn.acquire.run.run_file import RESERVE
from exidyn.acquire.views.live_view import Targets, start_view
from exidyn.drivers import StopLevel
from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan, write_plan

from ..controllers import controller
from ..motion import MODEL, ROBOT, TICK, job, motion
from ..run import run
from .checks import all_recorded, comes_to_rest, goes_on, no_jump, reports, stops
from .fault import SECONDS, Check, Row, Seen, Trigger, of_interest

ROOM = 300_000
"""Bytes that a small file system has beyond what the recorder keeps back: some two seconds of a run."""
Sinks = Callable[[PipeSink], Sequence[Sink]]


def file_faults(quick: bool) -> list[Row]:
    """All of them."""
    rows = [corrupt_plans(40 if quick else 400)]
    return rows if quick else [*rows, viewer_killed(), recorder_killed(), no_more_bytes(), disk_full()]


def viewer_killed() -> Row:
    """The process of the live view ends in the middle of the run."""

    def sinks(recorder: PipeSink) -> Sequence[Sink]:
        (view,) = start_view(Targets(save=Path(folder) / "run.rrd"))
        return [view, Trigger([(500, lambda: os.kill(view.process_id, signal.SIGKILL))])]

    must = "nothing: the view is for the eye, and the recording does not need it"
    with tempfile.TemporaryDirectory() as folder:
        return _row("viewer killed (SIGKILL)", must, Path(folder), sinks, (all_recorded, no_jump, goes_on))


def recorder_killed() -> Row:
    """The process that writes ends in the middle of the run."""

    def sinks(recorder: PipeSink) -> Sequence[Sink]:
        return [Trigger([(500, lambda: os.kill(recorder.process_id, signal.SIGKILL))])]

    must = "BRAKE: a run that is not recorded is worth no motion; what was written is readable"
    with tempfile.TemporaryDirectory() as folder:
        checks = (stops(StopLevel.BRAKE, "recorder"), no_jump)
        return _row("recorder killed (SIGKILL)", must, Path(folder), sinks, checks)


def no_more_bytes() -> Row:
    """The operating system lets the file grow no further."""

    def limit(recorder: PipeSink) -> None:
        most = 200_000
        resource.prlimit(recorder.process_id, resource.RLIMIT_FSIZE, (most, most))

    def sinks(recorder: PipeSink) -> Sequence[Sink]:
        return [Trigger([(1, lambda: limit(recorder))])]

    must = "BRAKE, and what was written is readable"
    with tempfile.TemporaryDirectory() as folder:
        checks = (stops(StopLevel.BRAKE, "recorder"), no_jump)
        return _row("file may not grow (RLIMIT_FSIZE)", must, Path(folder), sinks, checks)


def disk_full() -> Row:
    """A file system that is full in the middle of the run; in a name space of its own."""
    name, must = "disk full (tmpfs)", "BRAKE; the stop itself still fits into what was kept back"
    with tempfile.TemporaryDirectory() as folder:
        mount = f"mount -t tmpfs -o size={RESERVE + ROOM} none {folder}"
        mine = "-m" if os.geteuid() == 0 else "-rm"  # a mapped root has no real-time scheduling
        command = [
            "unshare",
            mine,
            "sh",
            "-c",
            f'{mount} && exec "$0" "$@"',
            sys.executable,
            "-P",
            "-m",
            __name__,
            folder,
        ]
        try:
            done = subprocess.run(
                command, stdout=subprocess.PIPE, text=True, check=True, env=imports_as_here()
            )
        except (OSError, subprocess.CalledProcessError) as error:
            return Row(name, must, f"not tried: no name space for it on this machine ({error})", [])
    happened, wrong = json.loads(done.stdout)
    return Row(name, must, happened, wrong)


def on_a_small_disk(folder: Path) -> None:
    """The run of `disk_full`, inside its name space."""
    checks = (
        stops(StopLevel.BRAKE, "recorder"),
        comes_to_rest,
        all_recorded,
        no_jump,
        reports("disk error"),
    )
    row = _row("", "", folder, lambda recorder: (), checks)
    print(json.dumps([row.cells[2], row.wrong]))


def _row(name: str, must: str, folder: Path, sinks: Sinks, checks: Sequence[Check]) -> Row:
    """A run on the mock, in real time."""
    path = folder / "run.mcap"
    try:
        with controller("mock", folder) as (driver, _):
            ran = run(driver, of_interest(job(SECONDS)), path, sinks=sinks)
        left = path if path.exists() else part_of(path)
        seen = Seen(ran, read_recording(left), "")
    except (ExidynError, OSError) as error:
        return Row(name, must, "an error", [f"{type(error).__name__}: {error}"])
    kept = f"; {seen.recording.signals['position'].time[-1]:.1f} s in {left.name}"
    return Row(name, must, seen.words + kept, [check(seen) for check in checks])


def corrupt_plans(count: int) -> Row:
    """Plans of which bytes were changed at random, as `exidyn record` takes them."""
    must = "one clear error: never a traceback, and never another motion"
    random, became, wrong = np.random.default_rng(0), Counter[str](), list[str]()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trajectory.toml"
        plan = Plan.of(motion(SECONDS), MODEL, tick=TICK)
        write_plan(plan, path)
        text = path.read_bytes()
        for _ in range(count):
            kind, data = damaged(text, random)
            path.write_bytes(data)
            found = fate(path, plan)
            became[found if found in FATES else "wrong"] += 1
            wrong += [] if found in FATES else [f"{kind}: {found}"]
    outcomes = ", ".join(f"{number} {fate}" for fate, number in became.most_common())
    return Row(f"trajectory file corrupt, {count} times", must, outcomes, _shortened(wrong))


def _shortened(wrong: list[str], most: int = 3) -> list[str]:
    more = len(wrong) - most
    return wrong if more <= 0 else [*wrong[:most], f"and {more} more"]


def damaged(text: bytes, random: np.random.Generator) -> tuple[str, bytes]:
    """A damage that disks, copies and editors do, and what is left of a text."""
    place = int(random.integers(len(text)))
    length = int(random.integers(1, 200))
    whole = bytearray(text)
    kinds = {
        "a bit flipped": lambda: (
            whole[:place] + bytes([whole[place] ^ 1 << random.integers(8)]) + whole[place + 1 :]
        ),
        "a byte lost": lambda: whole[:place] + whole[place + 1 :],
        "a byte more": lambda: whole[:place] + random.bytes(1) + whole[place:],
        "cut off": lambda: whole[:place],
        "a piece lost": lambda: whole[:place] + whole[place + length :],
        "a piece twice": lambda: whole[: place + length] + whole[place:],
        "a piece zeroed": lambda: (
            whole[:place] + bytes(len(whole[place : place + length])) + whole[place + length :]
        ),
        "a digit changed": lambda: _another_digit(whole, random),
    }
    kind = str(random.choice(list(kinds)))
    return kind, bytes(kinds[kind]())


def _another_digit(text: bytearray, random: np.random.Generator) -> bytearray:
    """What no syntax can notice."""
    digits = [place for place, byte in enumerate(text) if chr(byte).isdigit()]
    place = int(random.choice(digits))
    text[place] = ord("0") + (text[place] - ord("0") + int(random.integers(1, 10))) % 10
    return text


FATES = ("refused", "unharmed")


def fate(path: Path, plan: Plan) -> str:
    """What becomes of a plan; something else than one of `FATES` is wrong."""
    try:
        found = check_plan(read_plan(path), MODEL)
    except ExidynError:
        return _refusal(path)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    if found.warnings:
        return "refused"  # it is reported before anything is confirmed
    same = found.plan.trajectory.duration == plan.trajectory.duration and all(
        np.array_equal(a, b)
        for a, b in zip(found.plan.trajectory.every(TICK), plan.trajectory.every(TICK), strict=True)
    )
    return "unharmed" if same else "another motion"


def _refusal(path: Path) -> str:
    """The same from the command line: an exit code, and one line without a traceback."""
    printed = io.StringIO()
    with contextlib.redirect_stderr(printed):
        code = command_line.main(["record", str(path), "--robot", ROBOT])
    lines = printed.getvalue().splitlines()
    orderly = code == command_line.REFUSED and len(lines) == 1 and lines[0].startswith("exidyn: ")
    return "refused" if orderly else f"exit code {code} and {lines}"


if __name__ == "__main__":
    on_a_small_disk(Path(sys.argv[1]))
