"""exidyn drivers: which controllers there are, and the settings of one."""

import argparse
from collections.abc import Sequence

from exidyn.drivers import DRIVERS, explain
from exidyn.drivers.errors import UnknownDriver


def main(arguments: Sequence[str]) -> int:
    """List the drivers, or print a controller file of one to be filled in."""
    given = _parser().parse_args(arguments)
    if given.name is None:
        width = max(map(len, DRIVERS))
        for name, entry in DRIVERS.items():
            print(f"{name:<{width}}  {entry.purpose}")
        return 0
    if given.name not in DRIVERS:
        raise UnknownDriver(given.name, DRIVERS)
    print(explain(given.name), end="")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn drivers",
        description="List the drivers, or print the settings of one as a controller file for exidyn record.",
        epilog="example: exidyn drivers can_mit > cell.toml",
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="driver")
    return parser
