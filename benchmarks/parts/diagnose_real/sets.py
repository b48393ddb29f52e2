"""What is asked of the real recordings: priors without friction values, and runs."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.effects import LoadDependentFriction, known_parameters
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..real.data import FOLDER, KR300, LOADED, PANDA, UR10E, DataSet
from .known import ABSENT, KNOWN, Known

Runs = list[tuple[str, Recording]]
Ask = Callable[[], tuple[Model, Runs]]

CAD, WEIGHED = 0.1, 0.02
"""Relative standard deviation of inertias that are drawn, and of those that were weighed or identified from
minutes of motion [-]: the tolerance that exidyn takes for a drawing by default, and a fifth of it."""
GIVEN = Filtering(torque_cutoff=60.0, position_cutoff=80.0)
"""Cut-offs that the README of the motor's recordings identifies with [Hz]."""


@dataclass(frozen=True)
class Case:
    """One diagnosis."""

    title: str  # in the tables
    folder: str  # of the recordings
    prior: str  # of the robot, and what was not fields, in words
    ask: Ask  # makes the prior and reads the runs
    known: tuple[Known, ...] = ()  # what is known to be there
    absent: Mapping[str, str] = field(default_factory=dict)  # effect -> why it cannot be there
    control: bool = False  # whether nothing at all is there, so that every name is wrong
    quick: bool = False  # whether it is asked with --quick
    filtering: Filtering = Filtering()  # noqa: RUF009  # given cut-offs; chosen from the data by default


def read(folder: str, robot: str, fitted: Sequence[str], held_out: Sequence[str], **options: Any) -> Any:
    """Model of a folder's robot file, and its runs."""
    model = read_model(FOLDER / folder / robot)

    def run(name: str) -> Recording:
        return import_source(FOLDER / folder / f"{name}.csv.gz", model, **options)[0]

    return model, [*(("identify", run(n)) for n in fitted), *((HELD_OUT, run(n)) for n in held_out)]


def of_set(data: DataSet, fitted: Sequence[str], held_out: Sequence[str]) -> tuple[Model, Runs]:
    """Bare URDF and runs of an arm."""
    runs = [*(("identify", data.run(n)) for n in fitted), *((HELD_OUT, data.run(n)) for n in held_out)]
    return data.model(), runs


KR300_RUNS = (
    ("2020-10-21_A", "2020-10-21_C", "2020-10-16_A", "2020-10-19_B"),
    ("2020-10-21_B", "2020-10-19_C"),
)


def kr300_drawn() -> tuple[Model, Runs]:
    """The KR300 with its links as drawn; what it carries is a body of which nothing is stated."""
    model, runs = of_set(KR300, *KR300_RUNS)
    robot = replace(model.robot, inertias_stated=True, inertial_tolerance=CAD)
    carried = [(role, replace(run, payload=KnownPayload("tool"))) for role, run in runs]
    return replace(model, robot=robot), carried


def ur10e_loaded(calibrated: bool = False) -> tuple[Model, Runs]:
    """The UR10e as exidyn identified it without a load; and runs with one, of which nothing is stated.

    Drive gains are those published, or calibrated by a run with another body, of which the mass is known.
    """
    model, runs = UR10E.model(), [UR10E.run(name) for name in UR10E.train]
    effects = model.effects
    if calibrated:
        body, kilograms = LOADED[1]
        runs.append(UR10E.run(body, KnownPayload("known", (("M", kilograms),))))
        # Gears rub more under load, which gains would otherwise make up for.
        model = model + LoadDependentFriction()
    robot = identified(identify(runs, model=model)).robot
    robot = replace(robot, inertias_stated=True, inertial_tolerance=WEIGHED)
    loaded = [("identify", UR10E.run(LOADED[0][0])), (HELD_OUT, UR10E.run("id_ur-20_01_31-load"))]
    return Model(robot, effects), loaded  # friction is left open: oil has another temperature each day


MASSES = {"m535": 0.0, "m741": 0.206, "m969": 0.434, "m1168": 0.633}
"""Body of the servo's runs -> mass on the flange above that of the robot file [kg]."""
MOTIONS = ("sin_sin_kp16", "sin_time_square_kp16", "up_and_down_kp16"), ("sin_sin_kp24",)


def kscale() -> tuple[Model, Runs]:
    """The servo with weighed masses: one in the robot file, three as payloads."""
    names = [[f"{body}_l100_{motion}" for body in MASSES for motion in motions] for motions in MOTIONS]
    model, runs = read("kscale_sts3215", "robot.toml", *names)
    robot = replace(model.robot, inertias_stated=True, inertial_tolerance=WEIGHED)
    return replace(model, robot=robot), [(role, on_flange(run)) for role, run in runs]


def on_flange(run: Recording) -> Recording:
    """A run of the servo with the mass in its name."""
    body = run.name.split("_")[0]
    if not MASSES[body]:
        return run
    return replace(run, payload=KnownPayload(body, known_parameters(MASSES[body], (0.0, 0.0, 0.0))))


def bam() -> tuple[Model, Runs]:
    """The servo with one weighed mass and four position gains, the stiffest held out."""
    names = [[f"kp{kp}_{motion}" for kp in some for motion in SWINGS] for some in ((100, 200, 400), (800,))]
    model, runs = read("bam_xl330", "robot.toml", *names)
    weighed = {"inertias_stated": True, "inertial_tolerance": WEIGHED}
    robot = replace(model.robot, **weighed, drive_gain_tolerance=GUESSED)
    return replace(model, robot=robot), runs


SWINGS = ("sin_sin", "sin_time_square", "up_and_down", "lift_and_drop")
GUESSED = np.array([0.5])
"""Relative standard deviation of that servo's torque per duty, of which two methods differ by two [-]."""

BARE = "bare URDF, inertias not stated"
STATES = [(state, current) for state in ("nocomp", "comp") for current in ("measured", "setpoint")]
"""The motor's compensation off and on, and which current is taken for its torque."""


def motor(fitted: Sequence[str], held_out: str) -> tuple[Model, Runs]:
    """The motor, which has no gear."""
    model, runs = read("odrive_spin_slow", "robot.toml", fitted, [held_out], motor_side=["position"])
    return replace(model, robot=replace(model.robot, direct_drive=model.robot.joints)), runs


def odrive(state: str, current: str, filtering: Filtering | None = None) -> Case:
    """The motor in one state, with default filters or given ones."""
    numbers = {"nocomp": (4, 5, 6), "comp": (3, 7, 8)}[state]
    *fitted, held_out = (f"{state}_{number}_{current}" for number in numbers)
    control = (state, current) == ("comp", "setpoint")
    words = "off" if state == "nocomp" else "on", "measured" if current == "measured" else "set"
    return Case(
        f"motor, compensation {words[0]}, {words[1]} current{', cut-offs given' if filtering else ''}",
        "odrive_spin_slow",
        "robot.toml, inertia not stated, direct drive",
        partial(motor, fitted, held_out),
        () if control else KNOWN["odrive"],
        ABSENT["odrive"],
        control,
        filtering=filtering or Filtering(),
    )


def case(key: str, title: str, folder: str, prior: str, ask: Ask, **more: Any) -> Case:
    """A set with what is known of it."""
    return Case(title, folder, prior, ask, KNOWN[key], ABSENT[key], **more)


def cases() -> Iterator[tuple[str, Case]]:
    """Key and diagnosis."""
    arms: dict[str, tuple[str, str, str, Ask]] = {
        "emps": ("EMPS", "emps", "robot.toml, mass not stated",
                 partial(read, "emps", "robot.toml", ["train"], ["heldout_pulses"])),
        "tx40": ("TX40", "staubli_tx40", BARE,
                 partial(read, "staubli_tx40", "robot.toml", ["train"], ["heldout"])),
        "panda": ("Panda", "panda_gaz", f"{BARE}, links of 1 kg",
                  partial(of_set, PANDA, PANDA.train, PANDA.held_out)),
        "dvrk_psm": ("dVRK PSM", "dvrk_psm", f"{BARE}, masses that are placeholders",
                     partial(read, "dvrk_psm", "robot.toml", PSM_RUNS, ["fourier_test6"])),
        "kr300": ("KR300", "kuka_kr300_weigand", BARE, partial(of_set, KR300, *KR300_RUNS)),
        "kr300_drawn": ("KR300, links as drawn", "kuka_kr300_weigand",
                        "URDF with CAD masses stated to 10 %, an unknown body on the flange", kr300_drawn),
        "ur10e": ("UR10e", "ur10e_mamedov", f"{BARE}, published drive gains",
                  partial(of_set, UR10E, UR10E.train, UR10E.held_out[:2])),
        "ur10e_loaded": (
            "UR10e with a load", "ur10e_mamedov",
            "identified by exidyn without a load, inertias stated to 2 %, friction left open", ur10e_loaded),
        "ur10e_calibrated": (
            "UR10e with a load, gains calibrated", "ur10e_mamedov",
            "identified by exidyn with a known body in one run, inertias stated to 2 %, friction left open",
            partial(ur10e_loaded, calibrated=True)),
        "kscale": ("STS3215", "kscale_sts3215",
                   "robot.toml, masses stated to 2 %, three as payloads", kscale),
        "bam_xl330": ("XL330", "bam_xl330",
                      "robot.toml, mass stated to 2 %, torque per duty guessed to 50 %", bam),
    }  # fmt: skip
    yield "odrive_off", odrive("nocomp", "measured")
    yield "odrive_on", odrive("comp", "setpoint")
    for key, fields in arms.items():
        yield key, case(key, *fields, control=key in CONTROLS, quick=key in QUICK)
    yield "odrive_off_set", odrive("nocomp", "setpoint")
    yield "odrive_on_measured", odrive("comp", "measured")
    for state, current in STATES:
        yield f"odrive_{state}_{current}_given", odrive(state, current, GIVEN)


CONTROLS = ("panda", "dvrk_psm")
QUICK = ("emps", "kscale", "panda")
PSM_RUNS = ("fourier_test", *(f"fourier_test{number}" for number in range(2, 6)))
CASES = dict(cases())
"""Key -> diagnosis."""
