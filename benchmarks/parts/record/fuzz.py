"""Parsers: damaged files of every kind, and what is neither read nor refused in one line."""

from pathlib import Path
from tempfile import TemporaryDirectory

from common import show

from tests.parts.fuzz.fuzz import COMMAND, LONGEST, Outcome, fuzz
from tests.parts.fuzz.fuzz_parsers import PARSERS

INPUTS, QUICK = 400, 10
"""Of each parser, fewer of one that is slow. The tests try seeds from zero on; here they begin elsewhere."""
SEED = 1_000_000
HEADER = ("parser", "inputs", "read", "refused", "tracebacks", "longest line")


def main(quick: bool) -> dict[str, object]:
    count = QUICK if quick else INPUTS
    found = {name: _tried(name, max(count // one.slow, QUICK)) for name, one in PARSERS.items()}
    rows = [
        (name, one.inputs, one.read, one.refused, len(one.failures), len(one.longest))
        for name, one in found.items()
    ]
    show(f"Damaged files (a line has at most {LONGEST} characters)", HEADER, rows)
    for name, one in found.items():
        for seed, text in one.failures:
            print(f"  {name}, seed {seed}: {text}")
    return {
        "fuzz_inputs": sum(one.inputs for one in found.values()),
        "fuzz_tracebacks": sum(len(one.failures) for one in found.values()),
        "fuzz_longest_line": max(len(one.longest or COMMAND) for one in found.values()),
    }


def _tried(name: str, count: int) -> Outcome:
    with TemporaryDirectory() as folder:
        return fuzz(name, count, Path(folder) / "input", SEED)
