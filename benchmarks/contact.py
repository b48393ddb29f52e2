"""Contact by the identified model: false alarms, smallest force found, delays, weights as forces.

A threshold for one false alarm an hour comes from runs without contact. Touches are simulated in plain
MuJoCo; real arms are a UR10e, free, pushed by hand and with known payloads, and a servo with known masses
(`EXIDYN_DATA` names their folder).
"""

import os
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread

from common import options, save
from parts.contact.touches import free_motion, touches
from parts.real.data import FOLDER

PARTS = {"touches": touches, "ur10e": free_motion}


def main() -> None:
    """All tables."""
    given = options(__doc__, PARTS)
    figures: dict[str, Any] = {}
    for name, part in PARTS.items():
        if given.only and name not in given.only:
            continue
        if name != "touches" and not FOLDER.exists():
            print(f"\n{name}: no public recordings in {FOLDER}; EXIDYN_DATA names their folder")
            continue
        figures[name] = part(given.quick)
    save(given.json, figures)


if __name__ == "__main__":
    main()
