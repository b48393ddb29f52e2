"""Record: every driver against its peer beside a bare loop, and faults on purpose.

    python benchmarks/record.py [--quick] [--json FILE] [--only PART ...] [--drivers DRIVER ...]

Everything runs as `exidyn record` runs it: the loop in real time where that is allowed, the recorder in its
own process, and at the other end a peer that behaves as the controller does, over a real socket, bus or
pseudo-terminal. Peers simulate drives and arm on this computer's own processors.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

from common import parser, save
from parts.record import faults, timing
from parts.record.controllers import CONTROLLERS

PARTS = {"drivers": timing.main, "faults": faults.main}


def main() -> None:
    arguments = parser(__doc__.splitlines()[0], PARTS)
    arguments.add_argument(
        "--drivers", nargs="+", choices=list(CONTROLLERS), default=(), help="only these drivers"
    )
    chosen = arguments.parse_args()
    figures: dict[str, object] = {}
    for name in chosen.only or PARTS:
        figures |= PARTS[name](chosen.quick, drivers=chosen.drivers)
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
