"""Walks: how many functions and files are entered from what a person has to what they get."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SMALL = (
    "excite cobot --start 0 -90 0 0 0 0 --window 10 --degrees --tick 0.008 --length 9 --period 5 "
    "--harmonics 2 --search 1 -o small.toml"
)
"""Command that plans a motion of some seconds for the recording loop."""
RECORD = "record small.toml --robot cobot --approach --no-rehearsal --yes"
PEER = (str(ROOT / "tests" / "peers" / "ur_controller.py"), "--robot", "cobot", "--series", "cb3")
"""UR's peer as a CB3, whose cycles of 8 ms a busy machine keeps."""
SETTINGS = """driver = "ur_rtde"

[settings]
address = "{}"
cycle = 0.008
rtde_port = {}
program_port = {}
dashboard_port = {}
"""
WALKS = {
    "CSV log to fit": ("import log.csv --robot robot.toml --degrees", "identify log.mcap -o fit"),
    "two runs to diagnosis": ("diagnose first.mcap --validate second.mcap --robot robot.toml -o diagnosis",),
    "fit and two runs to one page": ("view fit first.mcap second.mcap",),
    "one cycle, mock": (f"{RECORD} --driver mock -o mock.mcap",),
    "one cycle, UR's socket": (f"{RECORD} --controller cell.toml -o ur.mcap",),
}
"""Walk -> its commands; those with one cycle begin with `RECORD`."""


def walk_counts(folder: Path, quick: bool) -> Iterator[tuple[str, int, int]]:
    """Name, functions and files of each walk, made in an empty folder; with `quick`, of the first one."""
    _exidyn(folder, "example files --output .")
    hook = folder / "hook"
    hook.mkdir()
    shutil.copy(Path(__file__).with_name("entered.py"), hook / "sitecustomize.py")
    if not quick:
        _write_inputs(folder)
    for name, commands in list(WALKS.items())[: 1 if quick else None]:
        yield name, *_walk(folder, commands)


def _write_inputs(folder: Path) -> None:
    """The two halves of the log as recordings, and the small motion."""
    header, *rows = (folder / "log.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    half = len(rows) // 2
    for name, part in (("first", rows[:half]), ("second", rows[half:])):
        (folder / f"{name}.csv").write_text("".join([header, *part]), encoding="utf-8")
        _exidyn(folder, f"import {name}.csv --robot robot.toml --degrees")
    _exidyn(folder, SMALL)


def _walk(folder: Path, commands: tuple[str, ...]) -> tuple[int, int]:
    file = folder / "walk.txt"
    file.unlink(missing_ok=True)
    hook = {"WALK_FILE": str(file), "WALK_HOOK": str(folder / "hook")}
    if commands[0].startswith(RECORD):
        hook["WALK_CYCLES"] = "1"
    with _peer(folder, any("cell.toml" in command for command in commands)):
        for command in commands:
            _exidyn(folder, command, hook)
    lines = {tuple(line.split("\t")) for line in file.read_text(encoding="utf-8").splitlines()}
    return sum(number != "0" for _, _, number in lines), len({place for place, _, _ in lines})


def _exidyn(folder: Path, command: str, hook: Mapping[str, str] = {}) -> None:  # noqa: B006
    import exidyn

    package = Path(exidyn.__file__).parent
    path = os.pathsep.join([*(value for name, value in hook.items() if name == "WALK_HOOK"), *sys.path])
    walk = {
        "WALK_PACKAGE": str(package),
        "PYTHONPATH": path,
        "OMP_NUM_THREADS": "1",
        "EXIDYN_UNATTENDED": "yes",
    }
    ran = subprocess.run(
        [sys.executable, "-m", "exidyn.acquire.command_line", *command.split()],
        cwd=folder,
        env={**os.environ, "EXIDYN_UNATTENDED": "yes", **hook, **walk},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    if ran.returncode:
        raise SystemExit(f"exidyn {command} ended with:\n{ran.stderr}")


@contextmanager
def _peer(folder: Path, needed: bool) -> Iterator[None]:
    """UR's peer, a process, and the controller file that names its ports."""
    if not needed:
        yield
        return
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, *PEER], stdin=pipe, stdout=pipe, text=True) as peer:
        assert peer.stdout is not None
        try:
            ready = next(line for line in peer.stdout if line.startswith("ready ")).split()[1:]
            (folder / "cell.toml").write_text(SETTINGS.format(*ready), encoding="utf-8")
            yield
        finally:
            peer.kill()
