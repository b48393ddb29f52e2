"""Parsers: damaged files of every kind, and what is neither read nor refused in one line."""

from pathlib import Path
from tempfile import TemporaryDirectory

from common import show

from tests.parts.fuzz.fuzz import COMMAND, LONGEST, Outcome, fuzz
from tests.parts.fuzz.fuzz_parsers import PARSERS

INPUTS, QUICK = 6000, 300
"""Damaged files of all parsers together."""
SEED = 1_000_000
"""First seed; the tests try seeds from zero on."""
HEADER = ("parser", "inputs", "read", "refused", "tracebacks", "longest line")


def main(quick: bool, seed: int = SEED) -> dict[str, object]:
    shares = shared(QUICK if quick else INPUTS)
    found = {name: _tried(name, count, seed) for name, count in shares.items()}
    rows = [
        (name, one.inputs, one.read, one.refused, len(one.failures), len(one.longest))
        for name, one in found.items()
    ]
    show(f"Damaged files (a line has at most {LONGEST} characters)", HEADER, rows)
    for name, one in found.items():
        for failing, text in one.failures:
            print(f"  {name}, seed {failing}: {text}")
    return {
        "fuzz_inputs": sum(one.inputs for one in found.values()),
        "fuzz_tracebacks": sum(len(one.failures) for one in found.values()),
        "fuzz_longest_line": max(len(one.longest or COMMAND) for one in found.values()),
    }


def shared(inputs: int) -> dict[str, int]:
    """How many of so many files each parser gets: fewer of a slow one, and all together exactly as many."""
    weights = {name: 1.0 / parser.slow for name, parser in PARSERS.items()}
    counts, rest, weight = {}, inputs, sum(weights.values())
    for name, own in weights.items():
        counts[name] = round(rest * own / weight)
        rest, weight = rest - counts[name], weight - own
    return counts


def _tried(name: str, count: int, seed: int) -> Outcome:
    with TemporaryDirectory() as folder:
        return fuzz(name, count, Path(folder) / "input", seed)
