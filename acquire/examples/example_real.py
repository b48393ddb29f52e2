"""Example: recordings of a real heavy robot, whose description lacks the counterbalance of joint 2."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from exidyn.identification.text_table import paragraph

from .example_arm import NOMINAL, Step, step

DATA = Path(__file__).parent / "kr300"
"""Folder of the recordings, with their license and source."""
FILES = tuple(sorted(path.name for path in DATA.iterdir() if path.is_file()))
KNOWN = (
    "Its publishers state a gas counterbalance on joint 2 and a tool of about 151 kg. The description has "
    "neither; it has the links as drawn. Ten seconds of motion were fitted, ten others only predicted.",
    "License and source: {}",
)


@dataclass(frozen=True)
class RecordedArm:
    """Files of an arm that was recorded."""

    def write(self, folder: Path) -> None:
        """Copy the files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name in FILES:
            shutil.copyfile(DATA / name, folder / name)


def steps(folder: Path, _length: float, _search: float | None) -> list[Step]:
    """Diagnose."""
    runs = folder / "fit.csv.gz", "--validate", folder / "held_out.csv.gz"
    return [step("diagnose", *runs, "--robot", folder / NOMINAL, "--output", folder / "exidyn-diagnosis")]


def outcome(folder: Path) -> str:
    """What is known of the robot from elsewhere."""
    return "\n".join(line for part in KNOWN for line in paragraph(part.format(folder / "SOURCE.md")))
