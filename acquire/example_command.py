"""exidyn example: plan, record and identify a simulated arm, and compare with the truth."""

import argparse
import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from exidyn.identify.errors import ExidynError

from . import excite_command, identify_command, record_command
from .example import GAIN_ERROR, MASS, comparison, make_example

SHORTEST = 20.0
"""Duration [s] of the motion below which ramps and filters leave too little of it."""

SEARCH = 20.0
"""How long the motion is searched [s]; a minute finds a better one."""


def main(arguments: Sequence[str]) -> int:
    """Run the commands that a person with a cell would, on the mock; print identified values beside true."""
    given = _parser().parse_args(arguments)
    folder, example = given.output, make_example(given.robot)
    _require_empty(folder)
    example.write(folder)
    believed, length, search = str(folder / "believed.toml"), f"{given.seconds:g}", f"{given.search:g}"
    motion, other = str(folder / "trajectory.toml"), str(folder / "other.toml")
    mass = ["--mass", f"{MASS:g}"]
    plan = [believed, "--length", length, "--payload", f"{MASS:g}", "--seconds", search, "--output", motion]
    _run("excite", excite_command.main, plan)
    plan = [
        believed,
        "--length",
        length,
        "--seconds",
        f"{min(given.search, 5.0):g}",
        "--seed",
        "7",
        "--output",
        other,
    ]
    _run("excite", excite_command.main, plan)
    paths: list[str] = []
    runs: tuple[tuple[str, str, str, list[str]], ...] = (
        ("unloaded", motion, "truth", []),
        ("loaded", motion, "truth-loaded", mass),
        ("other", other, "truth", []),
    )
    for seed, (name, path, plant, payload) in enumerate(runs, 1):
        paths.append(str(folder / f"{name}.mcap"))
        simulated = ["--driver", "mock", "--plant", str(folder / f"{plant}.toml"), "--seed", str(seed)]
        said = [path, "--robot", believed, *simulated, *payload, "--output", paths[-1]]
        _run("record", record_command.main, said)
    unloaded, loaded, validation = paths
    command = [unloaded, "--payload", loaded, *mass, "--validate", validation, "--output", str(folder)]
    _say("identify", command)
    fit = identify_command.run(command, identify_command.stopwatch())
    print(f"\nIdentified beside true; drive gains were believed {100 * GAIN_ERROR:.0f} % too large.\n")
    print(comparison(fit, example.truth))
    return 0


def _run(name: str, function: Callable[[Sequence[str]], int], arguments: list[str]) -> None:
    _say(name, arguments)
    if function(arguments):
        raise ExidynError(f"exidyn {name} has stopped; what it said is above")


def _say(name: str, arguments: list[str]) -> None:
    print(f"\n$ exidyn {name} {shlex.join(arguments)}", file=sys.stderr)


def _require_empty(folder: Path) -> None:
    taken = sorted(folder.glob("*.mcap*"))
    if taken:
        raise ExidynError(
            f"{taken[0]} exists, and recordings are not written over. Remove {folder}, or choose another "
            "(--output)"
        )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn example",
        description="Plan, record on a simulated controller and identify an arm whose truth is known.",
    )
    parser.add_argument("robot", nargs="?", choices=("kr270",), default="kr270", help="default: %(default)s")
    parser.add_argument(
        "--output", type=Path, default=Path("exidyn-example"), metavar="FOLDER", help="default: %(default)s"
    )
    parser.add_argument("--seconds", type=_seconds, default=40.0, help="of each run; default: %(default)s")
    parser.add_argument(
        "--search", type=_seconds_of_search, default=SEARCH, metavar="SECONDS",
        help="how long the motion is searched; default: %(default)s",
    )  # fmt: skip
    return parser


def _seconds(text: str) -> float:
    value = float(text)
    if not value >= SHORTEST:
        raise argparse.ArgumentTypeError(f"{text} is too short; at least {SHORTEST:g} s")
    return value


def _seconds_of_search(text: str) -> float:
    value = float(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"{text} is no time to search in; say above 0 s")
    return value
