"""Arms from MJCF: torque beside MuJoCo's own, and the gap between simulation and real arms.

`EXIDYN_DATA` names the folder of data, with models in `mjcf`. `round_trip` is the largest difference of a
joint's torque over the largest torque, in random motion, without dry friction, a constraint in MuJoCo.

concealed: 24 real arms are plain MuJoCo, with physics of the benchmark's own that their files lack or state
wrongly. exidyn is given two motions, and a third judges: `gap_left_*` are medians of the tool point's error
after 2 s over that of the original file. `named_percent` is the share of concealed items that are named on
their joint, `false` the count of others; `changed_for_nothing` counts attributes that are changed in the
arms with nothing concealed.

gears: an arm of two joints of which one has an elastic gear or play: the largest relative error of what is
written, and the error of that joint that it leaves.

sysid: mujoco.sysid is told which numbers of the real arm differ from the file, exidyn is told nothing.

recorded: real recordings with the models that users have. The tool point's error 0.1, 0.5 and 2 s after a
start is that of held-out runs, with the original file, the file as answered, and effects attached. A script
that `EXIDYN_RIVAL` names fits the servos of the SO-101 to the same runs and prints its errors.

speed: the median of steps a second with effects attached over those of plain MuJoCo, by process time within
one run. Plain MuJoCo has the file's own dry friction, a constraint, in place of the effects'.
"""

import os
import tempfile
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: matrices are small

from common import Kept, parser, save
from parts.simulator import concealed_gap, gears, recorded, round_trip, speed, sysid

PARTS = {
    "round_trip": round_trip.figures,
    "concealed": concealed_gap.figures,
    "gears": gears.figures,
    "sysid": sysid.figures,
    "recorded": recorded.figures,
    "speed": speed.figures,
}


def main() -> None:
    """Every part, printed and saved."""
    options = parser(__doc__.splitlines()[0], PARTS)
    options.add_argument("--resume", type=Path, metavar="FOLDER", help="keep results there; go on from them")
    arguments = options.parse_args()
    folder = Path(os.environ.get("EXIDYN_DATA", Path(__file__).parents[1] / "../shared/data"))
    if not any(folder.glob("mjcf/*.xml")):
        raise SystemExit("no models: EXIDYN_DATA names no folder with mjcf/*.xml")
    figures: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="simulator-") as scratch:
        place = arguments.resume or Path(scratch)
        place.mkdir(parents=True, exist_ok=True)
        kept = Kept(place / "results.jsonl")
        for name in arguments.only or PARTS:
            figures |= PARTS[name](folder, arguments.quick, kept)
    save(arguments.json, figures)


if __name__ == "__main__":
    main()
