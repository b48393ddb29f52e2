"""Record: every driver beside a bare loop, faults, stops that do not work, kills, damaged files, agreement.

    python benchmarks/record.py [--quick] [--json FILE] [--only PART ...] [--drivers DRIVER ...]

Everything runs as `exidyn record` runs it: the loop in real time where that is allowed, the recorder in its
own process, and at the other end a peer that behaves as the controller does, over a real socket, bus or
pseudo-terminal. Peers simulate drives and arm on this computer's own processors.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

from common import parser, save
from parts.record import bombs, example, fuzz, kill, told
from parts.record.controllers import CONTROLLERS
from parts.record.drivers import agreement
from parts.record.drivers import table as drivers
from parts.record.escalation import table as escalation
from parts.record.faults import table as faults
from parts.record.stops import table as stops

PARTS = {
    "drivers": drivers.main,
    "faults": faults.main,
    "stops": stops.main,
    "escalation": escalation.main,
    "told": told.main,
    "kills": kill.main,
    "parsers": fuzz.main,
    "bombs": bombs.main,
    "agreement": agreement.main,
    "example": example.main,
}

OF_DRIVERS = ("drivers", "faults", "stops", "agreement")
"""Parts that can be had of some drivers."""
QUICK = ("drivers", "faults", "stops", "escalation", "kills", "parsers")
"""What fits into a minute; the others take as long in small, with `--quick --only agreement example`."""


def main() -> None:
    arguments = parser(__doc__.splitlines()[0], PARTS)
    arguments.add_argument(
        "--drivers",
        nargs="+",
        choices=list(CONTROLLERS),
        default=(),
        help="only these, in the parts of drivers",
    )
    chosen = arguments.parse_args()
    figures: dict[str, object] = {}
    for name in chosen.only or (OF_DRIVERS if chosen.drivers else QUICK if chosen.quick else PARTS):
        of_drivers = {"drivers": chosen.drivers} if name in OF_DRIVERS else {}
        figures |= PARTS[name](chosen.quick, **of_drivers)
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
