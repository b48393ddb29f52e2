"""Arms from MJCF: torque beside MuJoCo's own, and the gap between simulation and real arms.

`EXIDYN_DATA` names the folder of data, with models in `mjcf`. `round_trip` is the largest difference of a
joint's torque over the largest torque, in random motion, without dry friction, a constraint in MuJoCo.

concealed: 24 real arms are plain MuJoCo, with physics of the benchmark's own that their files lack or state
wrongly; logs hold torque, or commands and positions alone. exidyn is given two motions, and a third judges:
`gap_left_file` and `gap_left_attached` are medians of the tool point's error after 2 s over that of the
original file, for the file alone and with effects attached. `named_percent` is the share of concealed items
that are named on their joint, `false` the count of others, `refused` that of arms without an answer.
`file_worse_than_original` counts files that are worse on the third motion, and `changed_for_nothing` the
attributes that are changed in the three arms with nothing concealed.

gears: an arm of two joints of which one has an elastic gear or play, its teeth a spring of the benchmark's;
`gears_written` of `gears` are found and written, `gear_error` is the largest relative error of their
stiffness or play, `gear_gap_left` the largest error of that joint after 0.5 s of commands, with the gear
over with fitted numbers alone.

sysid: in the real arm, armature, damping, frictionloss and delays differ from the file. exidyn is told
nothing; mujoco.sysid is told which numbers differ. `error_over_sysid`, on a third motion, and
`cpu_over_sysid` are the largest of all arms.

recorded: real recordings of a UR10e, a Panda, STS3215 and XL330 servos, an SO-101 and the legs of a Go2, with
the models that users have. The tool point's error 0.1, 0.5 and 2 s after a start is that of held-out runs,
with the original file, the file as answered, and effects attached. `recorded_worse_file` and
`recorded_worse_attached` of `recorded_joints` are farther off than with the original file;
`recorded_left_file` and `recorded_left_attached` are medians of a joint's error over the original one.

speed: the median of steps a second with these effects attached over those of plain MuJoCo, by process time
within one run; `slowest` that of the slowest arm. Plain MuJoCo has the file's own dry friction, a
constraint, in place of the effects': where a file has some, effects may cost less than that.
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
