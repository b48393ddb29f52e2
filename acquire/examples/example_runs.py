"""Examples that run commands, as a person would type them, on arms whose truth is known.

In the first, wrong nominal drive gains are identified with a known payload and compared with the truth. The
second has recordings of a real heavy robot, whose description lacks the counterbalance of joint 2.
"""

import shlex
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import at_point, digits, paragraph, table

MASS = 175.0
"""Mass of the payload, as in the paper [kg]."""
CENTER = (0.05, 0.03, -0.22)
"""Its center of mass [m]: a tool about twenty centimeters in front of the flange, which points along -z."""
INERTIA = (8.0, 0.1, 0.2, 9.0, 0.3, 7.0)
"""Its inertia about the center of mass, XX, XY, XZ, YY, YZ, ZZ [kg m^2]."""
BODY = known_parameters(MASS, CENTER, INERTIA)
"""True parameters of the payload; the stated ones may differ."""
NOMINAL, TRUTH, LOADED = "robot.toml", "truth.toml", "truth-loaded.toml"
"""Files of the nominal arm, the true arm, and the true arm with its payload."""
ITERATIONS, LEAST = 100, 25
"""Iterations of each start of a search, and those for motions that need not be optimal. Unlike a time, they
lead to the same motion on a slow or busy computer."""
GAIN_ERROR = 0.1
"""Relative error of the nominal drive gains; the paper found data sheets 8 to 19 % off."""
DATA = Path(__file__).parent / "kr300"
"""Folder of the recordings, with their license and source."""
FILES = tuple(sorted(path.name for path in DATA.iterdir() if path.is_file()))
KNOWN = (
    "Its publishers state a gas counterbalance on joint 2 and a tool of about 151 kg. The description has "
    "neither; it has the links as drawn. Ten seconds of motion were fitted, ten others only predicted.",
    "License and source: {}",
)


@dataclass(frozen=True)
class ExampleArm:
    """A true arm, whose nominal values are the true ones, and its nominal model with an error or omission."""

    truth: Model
    nominal: Model

    def files(self) -> Mapping[str, str]:
        """Robot files, name -> text."""
        models = {NOMINAL: self.nominal, TRUTH: self.truth, LOADED: self.truth + Payload("L", BODY)}
        return {name: commented_text(model) for name, model in models.items()}

    def write(self, folder: Path) -> None:
        """Write the robot files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.files().items():
            (folder / name).write_text(text, encoding="utf-8")


class Step(NamedTuple):
    """A command of exidyn and its arguments."""

    command: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"exidyn {self.command} {shlex.join(self.arguments)}"


def step(command: str, *arguments: str | Path | float) -> Step:
    """A command with its arguments; floats are printed without trailing zeros."""
    return Step(command, tuple(f"{a:g}" if isinstance(a, float) else str(a) for a in arguments))


def excited(
    folder: Path, name: str, length: float, search: float | None, *more: str | float, least: bool = False
) -> Step:
    """Command that plans a motion of a duration [s] in folder/name.toml.

    The duration `length` and the search time are in s; without a search time, the number of iterations is
    fixed. With `least`, the motion need not be optimal, and a quarter of the search is enough.
    """
    share = LEAST / ITERATIONS if least else 1.0
    budget = (
        ("--iterations", LEAST if least else ITERATIONS) if search is None else ("--search", search * share)
    )
    options = "--length", length, *more, *budget
    return step("excite", folder / NOMINAL, *options, "--output", folder / f"{name}.toml")


def recorded(folder: Path, name: str, motion: str, seed: int, *payload: str | float) -> Step:
    """Command that records folder/motion.toml in folder/name.mcap on the mock with the true arm.

    The payload options are the stated values; without them the true arm carries no payload.
    """
    plant = folder / (LOADED if payload else TRUTH)
    mock = "--driver", "mock", "--plant", plant, "--seed", str(seed)
    robot = "--robot", folder / NOMINAL
    return step(
        "record", folder / f"{motion}.toml", *robot, *mock, *payload, "--output", folder / f"{name}.mcap"
    )


def gains_arm() -> ExampleArm:
    """The KR270, and its model with nominal drive gains that are too large by `GAIN_ERROR`."""
    truth = read_model("kr270")
    gain = (1 + GAIN_ERROR) * truth.robot.drive_gain
    wrong = replace(truth.robot, drive_gain=gain, drive_gain_tolerance=np.full(truth.robot.dof, GAIN_ERROR))
    return ExampleArm(truth, replace(truth, robot=wrong))


def gains_steps(folder: Path, length: float, search: float | None) -> list[Step]:
    """Excite, record, identify. The plan needs the payload's center for its torque limits, not the fit."""
    mass = "--mass", MASS
    runs = folder / "unloaded.mcap", "--payload", folder / "loaded.mcap", *mass
    return [
        excited(folder, "trajectory", length, search, *mass, "--com", *CENTER),
        excited(folder, "other", length, search, "--seed", "7", least=True),
        recorded(folder, "unloaded", "trajectory", 1),
        recorded(folder, "loaded", "trajectory", 2, *mass),
        recorded(folder, "other", "other", 3),
        step("identify", *runs, "--validate", folder / "other.mcap", "--output", folder),
    ]


def gains_outcome(folder: Path) -> str:
    """Comparison of the identified and the true values."""
    text = f"Identified and true values; nominal drive gains are {100 * GAIN_ERROR:.0f} % too large."
    return f"{text}\n\n{comparison(read_fit(folder / 'fit.json'), read_model(str(folder / TRUTH)))}"


def comparison(fit: Fit, truth: Model) -> str:
    """Table of identified and true drive gains and spring coefficients."""
    joints, estimate = truth.robot.joints, fit.estimate
    rows = [
        (f"drive gain {joint}", "N m/A", *numbers)
        for joint, *numbers in zip(
            joints,
            truth.robot.drive_gain,
            fit.model.robot.drive_gain,
            estimate.gain,
            estimate.gain_std,
            strict=True,
        )
    ]
    true = dict(zip(truth.names, truth.nominal_values, strict=True))
    for name, meaning in (("Kr", "spring stiffness K_r"), ("K0", "spring preload K_0")):
        if name in fit.names:
            row = fit.names.index(name)
            nominal = fit.prior[0][row]
            rows.append(
                (meaning, fit.base.units[row], true[name], nominal, estimate.values[row], estimate.std[row])
            )
    true_values, nominal, identified, std = np.array([row[2:] for row in rows]).T
    texts = [at_point([digits(v) for v in column]) for column in (true_values, nominal, identified)]
    error = identified - true_values
    for column in (100 * (identified / true_values - 1), 100 * std / np.abs(identified), error / std):
        texts.append([f"{v:.3f}" for v in column])
    head = ["", "unit", "true", "nominal", "identified", "error %", "std %", "error/std"]
    labels = ([row[0] for row in rows], [row[1] for row in rows])
    return "\n".join(table(head, [list(row) for row in zip(*labels, *texts, strict=True)], left=(0, 1)))


@dataclass(frozen=True)
class RecordedArm:
    """Files of an arm that was recorded."""

    def write(self, folder: Path) -> None:
        """Copy the files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name in FILES:
            shutil.copyfile(DATA / name, folder / name)


def real_steps(folder: Path, _length: float, _search: float | None) -> list[Step]:
    """Diagnose."""
    runs = folder / "fit.csv.gz", "--validate", folder / "held_out.csv.gz"
    return [step("diagnose", *runs, "--robot", folder / NOMINAL, "--output", folder / "exidyn-diagnosis")]


def real_outcome(folder: Path) -> str:
    """What is known of the robot from elsewhere."""
    return "\n".join(line for part in KNOWN for line in paragraph(part.format(folder / "SOURCE.md")))
