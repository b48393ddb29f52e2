"""exidyn drivers: which controllers there are, and the settings of one."""

import argparse
from collections.abc import Sequence

from exidyn.drivers import driver_class, explain, known_drivers

from ..arguments.common import command_parser

EXAMPLES = (
    "exidyn drivers",
    "exidyn drivers can_mit > cell.toml",
    "exidyn drivers kuka_rsi --for-host 172.31.1.10 > RSI_EthernetConfig.xml",
)


def main(arguments: Sequence[str]) -> int:
    """List the drivers, or print a controller file of one to be filled in."""
    given = parser().parse_args(arguments)
    if given.name is None:
        drivers = known_drivers()
        width = max(map(len, drivers))
        for name, entry in drivers.items():
            print(f"{name:<{width}}  {entry.purpose}")
        return 0
    text = driver_class(given.name).controller_file(given.address) if given.address else explain(given.name)
    print(text, end="")
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn drivers` takes."""
    found = command_parser(
        "drivers",
        "List the drivers, or print the settings of one as a controller file for exidyn record.",
        EXAMPLES,
    )
    found.add_argument("name", nargs="?", metavar="DRIVER", help=", ".join(known_drivers()))
    found.add_argument(
        "--for-host",
        dest="address",
        metavar="ADDRESS",
        help="print instead the file that the controller itself needs to find this host, if it needs one "
        "(kuka_rsi: RSI_EthernetConfig.xml)",
    )
    return found
