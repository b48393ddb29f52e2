"""Record: every driver beside a bare loop, faults, stops that do not work, kills, agreement, the example.

    python benchmarks/record.py [--quick] [--json FILE] [--only PART ...]

Everything runs as `exidyn record` runs it: the loop in real time where that is allowed, the recorder in its
own process, and at the other end a peer that behaves as the controller does, over a real socket, bus or
pseudo-terminal. Peers simulate drives and arm on this computer's own processors.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

from common import options, save
from parts.record import example, fuzz, kill
from parts.record.drivers import agreement
from parts.record.drivers import table as drivers
from parts.record.escalation import table as escalation
from parts.record.faults import table as faults

PARTS = {
    "drivers": drivers.main,
    "faults": faults.main,
    "escalation": escalation.main,
    "kills": kill.main,
    "parsers": fuzz.main,
    "agreement": agreement.main,
    "example": example.main,
}

QUICK = ("drivers", "faults", "escalation", "kills", "parsers")
"""What fits into a minute; the others take as long in small, with `--quick --only agreement example`."""


def main() -> None:
    chosen = options(__doc__.splitlines()[0], PARTS)
    figures: dict[str, object] = {}
    for name in chosen.only or (QUICK if chosen.quick else PARTS):
        figures |= PARTS[name](chosen.quick)
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
