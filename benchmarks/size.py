"""Size of the repository: lines of Python beside their limits, commands, options, and ways through the code.

Limits stand in [tool.exidyn.size] of pyproject.toml. With --check, only they are compared, by the standard
library alone, and the exit code is 1 if one is exceeded. A way is walked in a process that notes which
functions and files of the package are entered.
"""

import argparse
import json
import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {
    "product": ("acquire", "drivers", "exidyn", "identify", "trajectories"),
    "tests": ("tests",),
    "benchmarks": ("benchmarks",),
}


def line_counts(root: Path) -> dict[str, int]:
    """Number of lines of the product, the tests and the benchmarks of a checkout."""
    return {
        part: sum(
            path.read_bytes().count(b"\n")
            for name in names
            for path in (root / name).rglob("*.py")
            if not path.is_symlink()
        )
        for part, names in FOLDERS.items()
    }


def exceeded_limits(counts: dict[str, int], limits: dict[str, int]) -> list[str]:
    """One sentence for each limit that is exceeded."""
    return [
        f"{part} has {counts[part]:,} lines of Python, {counts[part] - limit:,} more than the limit of "
        f"{limit:,} in [tool.exidyn.size] of pyproject.toml: remove lines, the limit is never raised"
        for part, limit in limits.items()
        if counts[part] > limit
    ]


def option_names() -> set[str]:
    """Long names of all options of all commands, without those of help."""
    from exidyn.acquire.commands import COMMANDS, command

    actions = [action for name in COMMANDS for action in command(name).parser()._actions]
    names = {name for action in actions for name in action.option_strings if name.startswith("--")}
    return names - {"--help"}


def show_ways(quick: bool) -> dict[str, dict[str, int]]:
    """Print how many commands and options there are, and what each walk enters."""
    from parts.size.walks import walk_counts

    from exidyn.acquire.commands import COMMANDS

    figures = {"command line": {"commands": len(COMMANDS), "options": len(option_names())}}
    print(f"{len(COMMANDS)} commands with {figures['command line']['options']} distinct options")
    with TemporaryDirectory() as folder:
        for name, functions, files in walk_counts(Path(folder), quick):
            print(f"{name}: {functions} functions in {files} files", flush=True)
            figures[name] = {"functions": functions, "files": files}
    return figures


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="print only limits that are exceeded")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    parser.add_argument("--quick", action="store_true", help="walk only the first way")
    options = parser.parse_args(arguments)
    limits = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["exidyn"]["size"]
    counts = line_counts(root)
    sentences = exceeded_limits(counts, limits)
    print(*sentences, sep="\n", end="\n" if sentences else "", file=sys.stderr)
    if not options.check:
        for part, count in counts.items():
            print(f"{part:<12}{count:>8,} lines, limit {limits[part]:>7,}")
        ways = show_ways(options.quick)
        if options.json:
            figures = {"lines": counts, "limits": limits, "ways": ways}
            options.json.write_text(json.dumps(figures, indent=2) + "\n")
    return 1 if options.check and sentences else 0


if __name__ == "__main__":
    sys.exit(main())
