"""What every benchmark shares: options, tables, JSON file, results kept, what its processes import from."""

import argparse
import json
import threading
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np


def options(description: str, parts: Collection[str] = ()) -> argparse.Namespace:
    """Command line of a benchmark: --quick and --json FILE; --only PART where it has parts."""
    return parser(description, parts).parse_args()


def parser(description: str, parts: Collection[str] = ()) -> argparse.ArgumentParser:
    """The same, for a benchmark that takes more."""
    found = argparse.ArgumentParser(description=description)
    found.add_argument("--quick", action="store_true", help="the same work in small, under a minute")
    found.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    if parts:
        found.add_argument("--only", nargs="+", choices=list(parts), metavar="PART", help=", ".join(parts))
    return found


def show(title: str, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print a table: text to the left, numbers to the right with four significant digits."""
    cells = [list(header), *([cell(value) for value in row] for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    left = [all(isinstance(row[k], str) for row in rows) for k in range(len(header))]
    print(f"\n{title}")
    for place, row in enumerate(cells):
        aligned = (c.ljust(w) if le else c.rjust(w) for c, w, le in zip(row, widths, left, strict=True))
        print("  " + "  ".join(aligned).rstrip())
        if place == 0:
            print("  " + "  ".join("-" * w for w in widths))


def cell(value: Any) -> str:
    """A value as text."""
    if isinstance(value, str):
        return value
    if value is None or np.isnan(value):
        return "-"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


def save(path: Path | None, figures: dict[str, Any]) -> None:
    """Write figures to a JSON file, if one was asked for."""
    if path is not None:
        path.write_text(json.dumps(figures, indent=2, default=_plain) + "\n")
        print(f"\nfigures in {path}")


WIDTH = 120
"""Of what is printed of a result that is kept: the file has the whole."""


class Kept:
    """Results by their name, each a line of a file as soon as it is there; a benchmark goes on from them.

    Without a file they last as long as the process.
    """

    def __init__(self, path: Path | None) -> None:
        lines = path.read_text().splitlines(True) if path is not None and path.exists() else []
        self.path, self.lock = path, threading.Lock()
        if path is not None and lines and not lines[-1].endswith("\n"):  # it was killed as it wrote
            path.write_text("".join(lines := lines[:-1]))
        self.found: dict[str, Any] = dict(json.loads(line) for line in lines)

    def of(self, name: str, make: Callable[[], Any]) -> Any:
        """The result of that name."""
        if name not in self.found:
            self.put(name, make())
        return self.found[name]

    def put(self, name: str, result: Any) -> None:
        """Write it down."""
        with self.lock:
            self.found[name] = json.loads(json.dumps(result, default=_plain))
            if self.path is not None:
                with self.path.open("a") as file:
                    file.write(json.dumps([name, self.found[name]]) + "\n")
        print(f"{name}: {str(self.found[name])[:WIDTH]}", flush=True)


def _plain(value: Any) -> Any:
    return sorted(value) if isinstance(value, set | frozenset) else np.asarray(value).tolist()
