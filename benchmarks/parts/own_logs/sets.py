"""Public recordings, which are right by their READMEs, and what is said of them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from exidyn.identification.errors import ExidynError
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source, read_tables
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.recordings.tables.table import Table
from exidyn.identification.robot_files.robot_file import read_model

from ..real.data import DE_LUCA, FOLDER, KR300_TURNS, piece
from .commands import claims_about, proposal_of, run
from .tables import Known, Statement, of_init

DIRECT = """<robot name="motor">
<link name="stator"/>
<joint name="rotor" type="continuous">
<parent link="stator"/><child link="body"/><axis xyz="0 0 1"/><limit velocity="200" effort="10"/>
</joint>
<link name="body"><inertial>
<mass value="0.1"/><inertia ixx="2e-4" iyy="2e-4" izz="1.8e-4" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
</robot>
"""
"""The motor of odrive_spin_slow without a gear: the one in its robot.toml is fictitious."""


GRAVITY = r"gravity|leans?|tilt|upside"


@dataclass(frozen=True)
class RealSet:
    """Recordings of one arm which are right by their README."""

    folder: str  # Folder of the set
    runs: tuple[str, ...]  # Names of its runs; the first stands for all with --quick
    robot: str  # Its robot file, in its folder
    drive: str = ""  # Lines of robot.toml that state what the README says beside that file
    options: dict[str, Any] = field(default_factory=dict)  # Options of the importer
    effort: str = "torque"  # What its efforts are, as in `Known`
    gain: np.ndarray | None = None  # Published gains of its drives; None where nobody knows
    alone: str = ""  # URDF by which init reads it; "" for its robot file
    facts: str = ""  # Pattern of statements that are true by the README
    open: str = ""  # Pattern of statements about which the README says that nobody knows

    @property
    def name(self) -> str:
        """Folder, and robot file where that is not the only one."""
        return f"{self.folder} ({self.robot}{', gains' if 'gain' in self.drive else ''})"

    def model(self) -> Model:
        """Its arm."""
        path = FOLDER / self.folder / self.robot
        if not self.drive:
            return read_model(path)
        kind = "mjcf" if path.suffix == ".xml" else "urdf"
        with TemporaryDirectory() as folder:
            robot = Path(folder) / "robot.toml"
            robot.write_text(f'format = 1\nname = "{path.stem}"\n{kind} = "{path.resolve()}"\n{self.drive}\n')
            return read_model(robot)

    @property
    def path(self) -> Path:
        """Its folder."""
        return FOLDER / self.folder

    def log(self, run: str) -> Path:
        """File of one of its runs."""
        return self.path / f"{run}.csv.gz"

    def table(self, run: str) -> Table:
        """One of its runs as columns."""
        return read_tables(self.log(run))[0]

    def copy(self, run: str, folder: Path) -> tuple[Path, Path]:
        """Copies of a run and of the file of the arm by which init reads it."""
        robot = self.path / self.robot
        log, arm = folder / self.log(run).name, folder / f"arm{'.urdf' if self.alone else robot.suffix}"
        log.write_bytes(self.log(run).read_bytes())
        text = robot.read_text().replace('urdf = "', f'urdf = "{self.path.resolve()}/')
        arm.write_text(self.alone or text)
        return log, arm

    def known(self, run: str) -> Known:
        """What is true of a run."""
        names = self.table(run).names
        if "columns" in self.options:
            columns = dict(self.options["columns"])
        else:
            numbers = range(1, sum(bool(re.fullmatch(r"q\d+", name)) for name in names) + 1)
            letters = {"position": "q", self.effort: "q_ref" if self.effort == "command" else "tau"}
            letters[self.effort] = "i" if "i1" in names else letters[self.effort]
            columns = {s: [f"{letter}{k}" for k in numbers] for s, letter in letters.items() if s}
        unit = "m" if self.folder == "emps" else "rad"
        gravity = not re.search("gravity", self.open)
        velocity = unit if "dq1" in names else ""
        return Known("s", unit, velocity, self.effort, self.gain, {"time": ["t"], **columns}, gravity)

    def read(self, run: str, model: Model) -> Recording:
        """One of its runs."""
        return import_source(self.log(run), model, **self.options)[0]

    def verdict(self, text: str) -> bool | None:
        """Whether a statement of the check is true: a suspicion is false, as the recordings are right."""
        if self.facts and re.search(self.facts, text, re.I):
            return True
        return None if self.open and re.search(self.open, text, re.I) else False


def _named(joints: Sequence[str]) -> dict[str, Any]:
    columns = {
        "position": [f"q_{joint}" for joint in joints],
        "command": [f"cmd_{joint}" for joint in joints],
    }
    return {"effort": "command", "columns": columns}


SO101 = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")
GO2 = [f"{leg}_{joint}" for leg in ("FL", "FR", "RL", "RR") for joint in ("hip", "thigh", "calf")]
GO2_DRIVE = f"joints = {[f'{joint}_joint' for joint in GO2]}\n[drive]\ngain = 20\nservo_gain = 1".replace(
    "'", '"'
)
SWINGS = [
    f"kp{kp}_{swing}"
    for kp in (100, 200, 400, 800)
    for swing in ("sin_sin", "sin_time_square", "up_and_down")
]
UR10E = (
    "id_ur-20_02_05-20sec_12harm", "id_ur-20_02_10-30sec_12harm", "id_ur-20_02_19_14harm50secLoad",
    "val_ur-20_01_17-ptp_10_points", "jointwise_ur-20_01_22-joint_3",
)  # fmt: skip
STATES = ("nocomp_4", "nocomp_5", "comp_3", "comp_8")
SERVO_LAW = r"kp|servo.?gain|gain of the (file|servo)"
SETS = (
    RealSet("kuka_lwr4", ("meas_1", "meas_2", "meas_3"), "arm.urdf", facts=GRAVITY),
    RealSet("airbot_play", ("opt", "ga_N12T25", "N7T25_5", "N7T25_7"), "play.urdf",
        facts=r"\blate\b|delay|earlier"),
    RealSet("dvrk_psm",
        ("fourier_test2", "fourier_test", *(f"fourier_test{number}" for number in range(3, 7))), "psm.urdf",
        effort="", facts="repeat", open=rf"{GRAVITY}|unit|factor|off by|gear|torque constant"),
    RealSet("kscale_sts3215", ("m535_l100_sin_sin_kp16", "m535_l100_up_and_down_kp16"),
        "robot_m535_l100.toml", effort="current", gain=np.array([0.53])),
    RealSet("kscale_sts3215", ("m1168_l150_sin_sin_kp16", "m1168_l150_sin_sin_kp24"),
        "robot_m1168_l150.toml", effort="current", gain=np.array([0.53])),
    RealSet("bam_xl330", tuple(SWINGS), "pend.urdf", effort="current", gain=np.array([0.0007]),
        facts="clip|saturat"),
    RealSet("pendubot", ("h1", "h2"), "robot.toml"),
    RealSet("go2_legs", ("legs",), "go2.xml", GO2_DRIVE, _named(GO2), "command", open=GRAVITY),
    RealSet("emps", ("train", "heldout_pulses"), "robot.toml"),
    RealSet("odrive_spin_slow",
        tuple(f"{state}_{current}" for state in STATES for current in ("measured", "setpoint")),
        "robot.toml", options={"motor_side": ["position"]}, effort="current", alone=DIRECT),
    RealSet("staubli_tx40", ("train", "heldout"), "tx40.urdf", facts="motor that turns with both"),
    RealSet("staubli_tx40", ("train_motor_side_torque", "heldout_motor_side_torque"),
        "robot_motor_side.toml"),
    RealSet("ur10e_mamedov", UR10E, "ur10e.urdf", effort="current", gain=DE_LUCA),
    RealSet("ur10e_mamedov", UR10E, "ur10e.urdf", f"[drive]\ngain = {DE_LUCA.tolist()}", effort="current",
        gain=DE_LUCA, facts="payload|flange"),
    RealSet("kuka_kr300_weigand",
        ("2020-10-21_A", "2020-10-21_B", "2020-10-21_C", "2020-10-16_A", "2020-10-19_B", "2020-10-19_C"),
        "kr300.urdf", f"[drive]\ngear_ratio = {KR300_TURNS.tolist()}", {"motor_side": ["torque"]},
        effort="current", gain=KR300_TURNS),
    RealSet("panda_gaz", ("traj1",), "panda.urdf"),
    RealSet("servo_miuzei", ("weight_00_chirp", "weight_31_prbs", "weight_40_prbs", "weight_51_prbs"),
        "robot.xml", options={"effort": "command"}, effort="command", facts=SERVO_LAW),
    RealSet("sage_so101", ("chirp_sweep", "multisine", "friction_gravity", "large_amplitude"), "so101.xml",
        options=_named(SO101), effort="command", facts=SERVO_LAW, open="zero|offset|counts"),
)  # fmt: skip
"""All sets. An MJCF's servos that a recording contradicts are a fact of servo_miuzei and sage_so101."""
QUICK = ("kuka_lwr4", "dvrk_psm", "kscale_sts3215", "pendubot", "emps", "bam_xl330")
"""Sets of which the first run is checked with --quick."""


def checked(data: RealSet, quick: bool) -> dict[str, Any]:
    """What import, the check and init say about a set: refusals, statements, and the seconds of init."""
    model, refused, statements, runs = data.model(), list[str](), list[Statement](), list[Recording]()
    names = data.runs[: 1 if quick else None]
    for name in names:
        try:
            runs.append(data.read(name, model))
        except ExidynError as error:
            refused.append(f"{data.name}/{name}: import: {error}")
    parts = dict(_parts(runs, quick))
    for name, part in parts.items():
        where = f"{data.name}/{name}"
        for claim in claims_about(part, model):
            true = data.verdict(claim.text)
            statements.append(Statement(where, claim.text, claim.probability, true))
    proposals = [_proposed(data, name) for name in names[1:]]  # of the first run by the walk to a fit
    return {
        "set": data.name,
        "checked": len(parts),
        "refused": refused,
        "statements": [one._asdict() for one in (*statements, *(s for found, _ in proposals for s in found))],
        "seconds": {"init": max((seconds for _, seconds in proposals), default=0.0)},
    }


def _proposed(data: RealSet, run_name: str) -> tuple[list[Statement], float]:
    """Guesses of init about a run, and its CPU time."""
    with TemporaryDirectory() as folder:
        log, arm = data.copy(run_name, Path(folder))
        table = Path(folder) / "init.json"
        done = run("init", log, "--robot", arm, "-o", Path(folder) / "robot.toml", "--json", table)
        proposal = proposal_of(table)
    found = of_init(f"{data.folder}/{run_name}", proposal, data.known(run_name)) if proposal else []
    return found, done.seconds


def _parts(runs: Sequence[Recording], quick: bool) -> Iterator[tuple[str, list[Recording]]]:
    """The set as a whole and its halves in time, each run, and the halves of the first run."""
    halves = () if quick else (0, 1)
    if len(runs) > 1:
        yield "all runs", list(runs)
        for half in halves:
            yield f"half {half + 1} of all runs", [_half(recording, half) for recording in runs]
    for recording in runs:
        yield recording.name, [recording]
    for half in halves if runs else ():
        yield f"half {half + 1} of {runs[0].name}", [_half(runs[0], half)]


def _half(recording: Recording, half: int) -> Recording:
    return piece(recording, half, half + 1, 2, recording.name)
