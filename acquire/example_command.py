"""exidyn example: simulate an arm, identify it from the recordings, compare with the truth."""

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path

from . import identify_command
from .example import GAIN_ERROR, MASS, comparison, simulated_example, write_example

SHORTEST = 20.0
"""Duration [s] that two base periods of the motion take; below, ramps and filters leave too little."""


def main(arguments: Sequence[str]) -> int:
    """Simulate three runs, run `exidyn identify` on them, print identified values beside true ones."""
    given = _parser().parse_args(arguments)
    progress = identify_command.stopwatch()
    progress(f"simulate 3 runs of {given.seconds:g} s: empty, with {MASS:g} kg, and another motion")
    example = simulated_example(given.robot, given.seconds)
    unloaded, loaded, other = map(str, write_example(example, given.output))
    command = [unloaded, "--payload", loaded, "--mass", f"{MASS:g}", "--validate", other]
    command += ["--output", str(given.output)]
    progress("exidyn identify " + shlex.join(command))
    fit = identify_command.run(command, progress)
    print(f"\nIdentified beside true; drive gains were believed {100 * GAIN_ERROR:.0f} % too large.\n")
    print(comparison(fit, example.truth))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn example",
        description="Simulate an arm whose truth is known, identify it, compare. Takes some seconds.",
    )
    parser.add_argument("robot", nargs="?", choices=("kr270",), default="kr270", help="default: %(default)s")
    parser.add_argument(
        "--output", type=Path, default=Path("exidyn-example"), metavar="FOLDER", help="default: %(default)s"
    )
    parser.add_argument("--seconds", type=_seconds, default=40.0, help="of each run; default: %(default)s")
    return parser


def _seconds(text: str) -> float:
    value = float(text)
    if not value >= SHORTEST:
        raise argparse.ArgumentTypeError(f"{text} is too short; at least {SHORTEST:g} s")
    return value
