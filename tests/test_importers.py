"""Other people's files."""

import gzip
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from exidyn.identify.effects import RigidBody
from exidyn.identify.errors import (
    BadTime,
    BadUnit,
    ExidynError,
    NotAFile,
    RecordingError,
    UnknownKey,
    WrongShape,
)
from exidyn.identify.importers import IMPORTERS, import_source, kind_of
from exidyn.identify.importers.case_folder import believed_model
from exidyn.identify.mcap_file import read_recording, write_recording
from exidyn.identify.model import Model
from exidyn.identify.motion import Motion
from exidyn.identify.recording import KnownPayload, Recording, Signal
from exidyn.identify.robot import Robot
from exidyn.identify.robot_file import read_model

BESIDE = Path(__file__).parents[2] / "shared"
DATA = Path(os.environ.get("EXIDYN_DATA", BESIDE / "data"))
CASES = Path(os.environ.get("EXIDYN_CASES", BESIDE / "cases"))
needs_data = pytest.mark.skipif(
    not DATA.is_dir(), reason="no real recordings; set EXIDYN_DATA to their folder"
)
needs_cases = pytest.mark.skipif(
    not CASES.is_dir(), reason="no sample cases; set EXIDYN_CASES to their folder"
)

TIME = np.arange(200) * 0.004


def model(joints: int = 2, **options) -> Model:
    kinematics = pin.Model()
    for place in range(joints):
        index = kinematics.addJoint(place, pin.JointModelRZ(), pin.SE3.Identity(), f"axis{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    return Model(Robot("small", kinematics, **options), (RigidBody(),))


def motion(joints: int = 2) -> np.ndarray:
    return 0.5 * np.sin(np.outer(TIME, 3.0 + np.arange(joints)))


def noise(joints: int = 2, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(TIME), joints))


def table(path: Path, header: str, *columns: np.ndarray, separator: str = ",", time=TIME) -> Path:
    rows = np.column_stack([time, *columns])
    lines = [header, *(separator.join(map(repr, row)) for row in rows.tolist())]
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "wt") as file:
        file.write("\n".join(lines) + "\n")
    return path


# ---- which importer ----


@pytest.mark.parametrize("name", IMPORTERS)
def test_every_importer_in_the_table_can_be_called(name, tmp_path):
    # Nothing is there to read, so that each one must say so in our words.
    empty = tmp_path / "empty"
    empty.write_bytes(b"")
    with pytest.raises(ExidynError):
        import_source(empty, model(), kind=name)


def test_a_source_that_is_nothing_lists_what_can_be(tmp_path):
    (tmp_path / "robot.stl").write_text("solid")
    with pytest.raises(NotAFile, match="Known are: CSV"):
        import_source(tmp_path / "robot.stl", model())
    with pytest.raises(NotAFile, match="does not exist"):
        import_source(tmp_path / "nothing.csv", model())
    with pytest.raises(UnknownKey, match="unknown key 'excel'"):
        import_source(tmp_path / "robot.stl", model(), kind="excel")


def test_an_unknown_option_lists_the_valid_ones(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise())
    with pytest.raises(UnknownKey, match="import of csv: unknown key 'degree'. Valid keys: columns, degrees"):
        import_source(path, model(), degree=True)


def test_an_own_file_is_read_as_it_is(tmp_path):
    signals = {"position": Signal(TIME, motion()), "current": Signal(TIME, noise())}
    write_recording(Recording("run", model(), signals), tmp_path / "run.mcap")
    [found] = import_source(tmp_path / "run.mcap")
    assert np.array_equal(found.signals["current"].values, noise())


# ---- tables ----


@pytest.mark.parametrize(
    ("name", "separator"), [("run.csv", ","), ("run.csv.gz", ","), ("run.csv", ";"), ("run.tsv", "\t")]
)
def test_a_table_with_usual_names(tmp_path, name, separator):
    header = separator.join("t q1 q2 dq1 dq2 i1 i2 tau1 tau2 temp1 temp2 ql1 ql2 q_ref1 q_ref2".split())
    columns = [motion(), noise(seed=1), noise(seed=2), noise(seed=3), 40 + noise(), motion(), motion()]
    [found] = import_source(table(tmp_path / name, header, *columns, separator=separator), model())
    names = ("position", "velocity", "current", "torque", "temperature", "link_position", "command")
    assert found.name == "run"
    assert set(found.signals) == set(names)
    for signal, values in zip(names, columns, strict=True):
        assert np.array_equal(found.signals[signal].values, values), signal
        assert np.array_equal(found.signals[signal].time, np.rint(TIME * 1e9) / 1e9)


@pytest.mark.parametrize(
    "header",
    ["time,q_axis1,q_axis2,i_axis1,i_axis2", "t,axis1_position,axis2_position,axis1/current,axis2/current"],
)
def test_a_table_named_by_joint(tmp_path, header):
    [found] = import_source(table(tmp_path / "run.csv", header, motion(), noise()), model())
    assert np.array_equal(found.signals["position"].values, motion())
    assert np.array_equal(found.signals["current"].values, noise())


def test_a_table_with_mapped_names(tmp_path):
    path = table(
        tmp_path / "run.csv", "ms,A1,A2,J_axis1_amps,J_axis2_amps", motion(), noise(), time=TIME * 1000
    )
    columns = {"time": "ms", "position": ["A1", "A2"], "current": "J_{joint}_amps"}
    [found] = import_source(path, model(), columns=columns, time_scale=1e-3)
    assert np.array_equal(found.signals["current"].values, noise())
    np.testing.assert_allclose(found.signals["current"].time, TIME, atol=1e-9)


def test_degrees_and_motor_side_become_the_joint(tmp_path):
    gears = np.array([100.0, -50.0])
    header = "t,q1,q2,tau1,tau2"
    path = table(tmp_path / "run.csv", header, np.degrees(motion()) * gears, noise() / gears)
    [found] = import_source(path, model(gear_ratio=gears), degrees=True, motor_side=True)
    np.testing.assert_allclose(found.signals["position"].values, motion(), atol=1e-12)
    np.testing.assert_allclose(found.signals["torque"].values, noise(), atol=1e-12)
    path = table(tmp_path / "run.csv", header, motion(), noise() / gears)
    [found] = import_source(path, model(gear_ratio=gears), motor_side=["torque"])
    assert np.array_equal(found.signals["position"].values, motion())
    np.testing.assert_allclose(found.signals["torque"].values, noise(), atol=1e-12)


def test_irregular_stamps_stay_and_begin_at_zero(tmp_path):
    time = 1_000.0 + TIME + np.random.default_rng(0).uniform(0, 0.001, len(TIME))
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise(), time=time)
    [found] = import_source(path, model())
    np.testing.assert_allclose(found.signals["position"].time, time - time[0], atol=1e-9)
    assert float(found.settings["first_time_stamp_s"]) == time[0]


def test_rows_before_the_recorder_settled_can_be_skipped(tmp_path):
    time = TIME.copy()
    time[0] = 3000.0
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise(), time=time)
    with pytest.raises(BadTime, match="skip_rows"):
        import_source(path, model())
    [found] = import_source(path, model(), skip_rows=1)
    assert len(found.signals["position"]) == len(TIME) - 1


def test_joints_without_a_second_encoder_are_silent(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2,ql1", motion(), noise(), motion()[:, 0])
    [found] = import_source(path, model())
    assert np.array_equal(found.signals["link_position"].values[:, 0], motion()[:, 0])
    assert np.isnan(found.signals["link_position"].values[:, 1]).all()


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("", NotAFile, "is empty"),
        ("t,q1,q2,i1,i2\n", NotAFile, "has no samples"),
        ("t,q1,i1,i2\n0,0,0,0\n", WrongShape, "no column q2 for position. Columns: t, q1, i1, i2"),
        ("x,q1,q2,i1,i2\n0,0,0,0,0\n", WrongShape, "no column of time"),
        ("t,q1,q2\n0,0,0\n1,1,1\n", WrongShape, "needs position and one of current, torque"),
        ("t,q1,q2,i1,i2\n0,0,0,0\n", WrongShape, "5 names for 4 columns"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n1,,0,0,0\n", WrongShape, "could not convert string '' to float64"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n1,0,0\n", WrongShape, "number of columns changed"),
        (
            "t,q1,q2,q3,i1,i2,i3\n0,0,0,0,0,0,0\n",
            WrongShape,
            "column q3, but small has 2 joints: axis1, axis2",
        ),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n0.002,90,0,1,1\n", BadUnit, "looks like degrees"),
    ],
)
def test_a_bad_table_says_what_is_wrong(tmp_path, content, error, message):
    (tmp_path / "run.csv").write_text(content)
    with pytest.raises(error, match=message):
        import_source(tmp_path / "run.csv", model())


def test_a_table_cut_off_in_the_middle_of_its_compression(tmp_path):
    path = table(tmp_path / "run.csv.gz", "t,q1,q2,i1,i2", motion(), noise())
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(NotAFile, match="cannot be read as a table"):
        import_source(path, model())


def test_a_table_that_is_not_compressed_as_it_says(tmp_path):
    (tmp_path / "run.csv.gz").write_text("t,q1\n")
    with pytest.raises(NotAFile, match="cannot be read as a table"):
        import_source(tmp_path / "run.csv.gz", model())


def test_bad_maps_are_refused(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise())
    with pytest.raises(WrongShape, match="columns: unknown amps. Valid: time, position"):
        import_source(path, model(), columns={"amps": "i{number}"})
    with pytest.raises(WrongShape, match="position has 1 columns, small 2 joints"):
        import_source(path, model(), columns={"position": ["q1"]})
    with pytest.raises(WrongShape, match="no column amps1, amps2 for current"):
        import_source(path, model(), columns={"current": "amps{number}"})
    with pytest.raises(RecordingError, match="give the robot too"):
        import_source(path)


# ---- the real recordings ----


@needs_data
def test_ur10e_currents_with_their_jitter():
    folder = DATA / "ur10e_mamedov"
    payload = KnownPayload("L", (("M", 2.805),))
    path = folder / "id_ur-20_02_19_14harm50secLoad.csv.gz"
    [found] = import_source(path, read_model(folder / "ur10e.urdf"), payload=payload)
    assert set(found.signals) == {"position", "velocity", "current"}
    assert found.signals["position"].values.shape == (5307, 6)
    assert found.signals["position"].period == pytest.approx(0.010)
    assert np.ptp(np.diff(found.signals["position"].time)) > 0
    assert found.payload == payload
    assert found.warnings == ()


@needs_data
def test_kr300_torques_come_to_the_joint_and_three_joints_have_a_second_encoder():
    folder = DATA / "kuka_kr300_weigand"
    gears = np.array([256.857, 267.429, 252.333, 221, 239.619, 154.323])
    described = read_model(folder / "kr300.urdf")
    robot = Robot("kr300", described.robot.kinematics, described.robot.limits, gear_ratio=gears)
    path = folder / "2020-10-21_A.csv.gz"
    [found] = import_source(path, Model(robot, described.effects), motor_side=["torque"])
    raw = np.genfromtxt(path, delimiter=",", names=True)
    np.testing.assert_allclose(found.signals["torque"].values[:, 1], raw["tau2"] * gears[1])
    assert np.array_equal(found.signals["position"].values[:, 4], raw["q5"])
    second = found.signals["link_position"].values
    assert np.isfinite(second[:, :3]).all()
    assert np.isnan(second[:, 3:]).all()


@needs_data
def test_panda_keeps_its_stamps_and_says_so(tmp_path):
    folder = DATA / "panda_gaz"
    [found] = import_source(folder / "traj1.csv.gz", read_model(folder / "panda.urdf"))
    assert len(found.signals["torque"]) == 20544
    assert "gaps" in found.warnings[0]
    assert "longest 8.800 ms" in found.warnings[0]
    write_recording(found, tmp_path / "panda.mcap")
    read = read_recording(tmp_path / "panda.mcap")
    assert np.array_equal(read.signals["torque"].values, found.signals["torque"].values)
    assert np.array_equal(read.signals["torque"].time, found.signals["torque"].time)
    assert read.warnings == found.warnings


# ---- case folders ----


@needs_cases
def test_a_case_brings_its_runs_roles_and_payload():
    runs = import_source(CASES / "s1")
    assert [run.settings["role"] for run in runs] == ["identify", "identify", "validate", "payload", "slow"]
    assert [run.name for run in runs][:2] == ["s1/identify_a", "s1/identify_b"]
    assert all(run.signals["position"].values.shape == (12000, 6) for run in runs)
    assert [run.payload is not None for run in runs] == [False, False, False, True, False]
    known = dict(runs[3].payload.known)
    assert known["M"] == 62.0
    assert known["MZ"] == pytest.approx(62.0 * -0.18)
    assert known["XX"] == pytest.approx(1.0979166666666664 + 62.0 * (0.06**2 + 0.18**2))
    assert len(import_source(CASES / "s1" / "case.toml", role="validate")) == 1


@needs_cases
def test_a_case_states_its_model():
    believed = believed_model(CASES / "s1")
    values = dict(zip(believed.names, believed.beliefs, strict=True))
    assert "Fc5" not in believed.names
    assert [name for name in believed.names if name.startswith("Off")] == ["Off2", "Off4", "Off5", "Off6"]
    assert values["Ia1"].value == 1113.29
    assert values["Ia1"].std == pytest.approx(111.329)
    assert values["Fv2"].std == pytest.approx(0.2 * 2518.72)
    assert values["Off2"].std == np.inf
    assert values["Kr"].value == 50400.0
    assert values["K0"].std == pytest.approx(7850.0)
    assert believed.robot.drive_gain[5] == 212.587
    assert believed.robot.limits.acceleration[0] == 2.56


@needs_cases
@pytest.mark.parametrize("case", ["s1", "s4"])
def test_the_stated_model_balances_as_the_case_says(case):
    """Against the formulas at the top of case.toml, written out once more."""
    believed = believed_model(CASES / case)
    random = np.random.default_rng(0)
    limits = believed.robot.limits
    q = random.uniform(limits.position_lower, limits.position_upper, (20, 6))
    dq, ddq = random.normal(size=(2, 20, 6))
    kinematics, data = believed.robot.kinematics, believed.robot.kinematics.createData()
    expected = np.array([pin.rnea(kinematics, data, *row) for row in zip(q, dq, ddq, strict=True)])
    values = dict(zip(believed.names, believed.believed_values, strict=True))
    for joint in range(6):
        expected[:, joint] += values.get(f"Ia{joint + 1}", 0.0) * ddq[:, joint]
        expected[:, joint] += values.get(f"Fv{joint + 1}", 0.0) * dq[:, joint]
        expected[:, joint] += values.get(f"Fc{joint + 1}", 0.0) * np.tanh(dq[:, joint] / 0.003)
    q21 = -1.6148 + q[:, 1]
    length = np.sqrt(0.6964**2 + 0.1847**2 + 2 * 0.6964 * 0.1847 * np.cos(q21))
    force = 50400.0 * length - 78500.0
    expected[:, 1] -= -force * 0.6964 * 0.1847 * np.sin(q21) / length
    torque = believed.torque(Motion.of(np.arange(20.0), q, dq, ddq), believed.believed_values)
    np.testing.assert_allclose(torque, expected, rtol=1e-9, atol=1e-6)


@needs_cases
def test_a_case_survives_its_own_file(tmp_path):
    [run] = import_source(CASES / "s1", role="payload")
    write_recording(run, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert read.payload == run.payload
    assert read.settings == run.settings
    assert read.model.names == run.model.names
    np.testing.assert_allclose(read.model.believed_values, run.model.believed_values, rtol=1e-12)
    np.testing.assert_allclose(
        [b.std for b in read.model.beliefs], [b.std for b in run.model.beliefs], rtol=1e-9
    )
    assert np.array_equal(read.signals["current"].values, run.signals["current"].values)


def test_a_case_that_is_none(tmp_path):
    (tmp_path / "case.toml").write_text("[case]\nformat = 7\n")
    with pytest.raises(NotAFile, match="format is 7; this version reads 1"):
        import_source(tmp_path)
    (tmp_path / "case.toml").write_text("[case\n")
    with pytest.raises(NotAFile, match="is not TOML"):
        import_source(tmp_path)
    (tmp_path / "case.toml").write_text("[case]\nformat = 1\n")
    with pytest.raises(RecordingError, match="key 'robot' is missing"):
        import_source(tmp_path)


# ---- KUKA traces ----


def trace(
    path: Path, period: float, channels: list[tuple], layout: str = "BLOCK", german: bool = True, cut: int = 0
) -> None:
    """Write a header and its data, value by value; channels are (name, unit, values, factor, offset)."""
    count = len(channels[0][2])
    words = ("IMPLIZIT", "EXPLIZIT") if german else ("IMPLICIT", "EXPLICIT")
    lines = ["DIAEXTENDED  {@:ENGLISH", "#BEGINGLOBALHEADER", "101,KRC trace", "#ENDGLOBALHEADER"]
    lines += ["#BEGINCHANNELHEADER", "200,Zeit", "201,", "202,s", f"210,{words[0]}", f"220,{count}", "240,0"]
    lines += [f"241,{period}", "#ENDCHANNELHEADER"]
    for place, (name, unit, _, factor, offset) in enumerate(channels):
        first = place + 1 if layout == "BLOCK" else place * count + 1
        lines += ["#BEGINCHANNELHEADER", f"200,{name}", "201,Überschrift", f"202,{unit}", f"210,{words[1]}"]
        lines += [f"211,{path.stem}.r64", f"213,{layout}", "214,REAL64", f"220,{count}", f"221,{first}"]
        lines += [f"240,{offset}", f"241,{factor}", "#ENDCHANNELHEADER"]
    path.write_bytes("\r\n".join(lines).encode("iso-8859-1"))
    raw = [[(value - offset) / factor for value in values] for _, _, values, factor, offset in channels]
    order = (
        [v for row in zip(*raw, strict=True) for v in row]
        if layout == "BLOCK"
        else [v for c in raw for v in c]
    )
    data = b"".join(struct.pack("<d", value) for value in order)
    path.with_suffix(".r64").write_bytes(data[: len(data) - cut])


def write_traces(
    folder: Path, layout: str = "BLOCK", german: bool = True, cut: int = 0
) -> tuple[np.ndarray, ...]:
    position, current, torque = np.degrees(motion()), noise(), 100 * noise(seed=1)
    kelvin = 310.0 + noise(seed=2)
    for axis in range(2):
        channels = [
            ("Sollposition", "°", position[:, axis] + 0.001, 1e-6, 0.0),
            ("Istposition", "°", position[:, axis], 1e-6, 10.0),
            ("Unbekannt", "furlong", torque[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 0.5, 0.0),
            ("Istmoment", "Nm", torque[:, axis], 1.0, 0.0),
            ("Motortemperatur", "K", kelvin[:, axis], 1.0, 0.0),
        ]
        trace(folder / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels, layout, german, cut)
    ipo = [(f"AxisPos_CmdIpo{axis + 1}", "°", position[::3, axis], 1.0, 0.0) for axis in range(2)]
    trace(folder / "Lauf 7_KRCIpo.dat", 0.012, ipo, layout, german)
    return position, current, torque, kelvin


@pytest.mark.parametrize("layout", ["BLOCK", "CHANNEL"])
@pytest.mark.parametrize("german", [True, False])
def test_kuka_traces_of_all_drives_are_one_run(tmp_path, layout, german):
    position, current, torque, kelvin = write_traces(tmp_path, layout, german)
    [found] = import_source(tmp_path, model())
    assert found.name == "Lauf 7"
    signals = found.signals
    np.testing.assert_allclose(signals["position"].values, np.radians(position), atol=1e-12)
    np.testing.assert_allclose(signals["current"].values, current, atol=1e-12)
    np.testing.assert_allclose(signals["torque"].values, torque, atol=1e-12)
    np.testing.assert_allclose(signals["temperature"].values, kelvin - 273.15, atol=1e-9)
    np.testing.assert_allclose(signals["command"].values, np.radians(position + 0.001), atol=1e-12)
    np.testing.assert_allclose(signals["position"].time, TIME, atol=1e-9)
    assert found.warnings == ()


def test_kuka_interpolator_alone_gives_commands_at_its_own_rate(tmp_path):
    position, current, *_ = write_traces(tmp_path)
    for axis in range(2):
        channels = [
            ("Istposition", "Grad", position[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 1.0, 0.0),
        ]
        trace(tmp_path / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels)
    [found] = import_source(tmp_path / "Lauf 7_NextGenDrive#1.dat", model())
    assert found.signals["position"].period == pytest.approx(0.004)
    assert found.signals["command"].period == pytest.approx(0.012)
    np.testing.assert_allclose(found.signals["command"].values, np.radians(position[::3]), atol=1e-12)


def test_kuka_unknown_units_are_left_out_with_a_doubt(tmp_path):
    position, current, *_ = write_traces(tmp_path)
    for axis in range(2):
        channels = [
            ("Istposition", "°", position[:, axis], 1.0, 0.0),
            ("Iststrom", "A", current[:, axis], 1.0, 0.0),
            ("Istmoment", "%", current[:, axis], 1.0, 0.0),
        ]
        trace(tmp_path / f"Lauf 7_NextGenDrive#{axis + 1}.dat", 0.004, channels)
    [found] = import_source(tmp_path, model())
    assert "torque" not in found.signals
    assert "Istmoment was left out: its unit is '%'" in found.warnings[0]


def test_kuka_data_cut_off_are_read_up_to_the_cut(tmp_path):
    position, *_ = write_traces(tmp_path, cut=6 * 8 * 20 + 3)
    [found] = import_source(tmp_path, model())
    assert found.signals["position"].values.shape == (179, 2)
    np.testing.assert_allclose(found.signals["position"].values, np.radians(position[:179]), atol=1e-12)
    assert "Lauf 7_NextGenDrive#1.r64 ends abruptly: 179 of 200 samples are there" in found.warnings


def test_kuka_traces_that_are_not_whole_say_so(tmp_path):
    write_traces(tmp_path)
    with pytest.raises(RecordingError, match="axis 2, but small has 1"):
        import_source(tmp_path, model(joints=1))
    with pytest.raises(
        RecordingError, match="current of axis3 is not finite|position of axis3 is not finite"
    ):
        import_source(tmp_path, model(joints=3))
    with pytest.raises(NotAFile, match="no trace other. Traces here: Lauf 7"):
        import_source(tmp_path, model(), name="other")
    (tmp_path / "Lauf 7_NextGenDrive#1.r64").unlink()
    with pytest.raises(NotAFile, match="which is not beside it"):
        import_source(tmp_path, model())
    (tmp_path / "Lauf 7_NextGenDrive#1.dat").write_text("hello")
    with pytest.raises(NotAFile, match="is no DIAdem header"):
        import_source(tmp_path, model())


# ---- ROS 2 bags ----


def write_bag(
    folder: Path, storage: str, stamped: bool = True, names=("axis2", "axis1"), effort: bool = True
) -> None:
    """A bag whose joints are in another order than the robot's, written by rosbags."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    time, array = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Float64MultiArray"]
    layout = store.types["std_msgs/msg/MultiArrayLayout"]
    plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
    with rosbag2.Writer(folder, version=9, storage_plugin=plugin) as writer:
        states = writer.add_connection("/arm/joint_states", state.__msgtype__, typestore=store)
        currents = writer.add_connection("/motor_current", array.__msgtype__, typestore=store)
        for k, moment in enumerate(np.rint(TIME * 1e9).astype(np.int64).tolist()):
            stamp = time(100 + moment // 10**9, moment % 10**9) if stamped else time(0, 0)
            position, torque = motion()[k, ::-1].copy(), noise()[k, ::-1].copy()
            silent = np.empty(0)
            message = state(header(stamp, ""), list(names), position, silent, torque if effort else silent)
            host = 1_700_000_000_000_000_000 + moment + (k % 7) * 1000
            writer.write(states, host, store.serialize_cdr(message, state.__msgtype__))
            message = array(layout([], 0), noise(seed=5)[k])
            writer.write(currents, host + 500, store.serialize_cdr(message, array.__msgtype__))


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_is_read_by_the_names_of_the_joints(tmp_path, storage):
    write_bag(tmp_path / "bag", storage)
    [found] = import_source(tmp_path / "bag", model())
    assert np.array_equal(found.signals["position"].values, motion())
    assert np.array_equal(found.signals["torque"].values, noise())
    assert np.array_equal(found.signals["current"].values, noise(seed=5))
    assert "velocity" not in found.signals
    np.testing.assert_allclose(found.signals["position"].time, TIME, atol=1e-9)
    assert found.host_time[0] == 1_700_000_000_000_000_000
    assert found.signals["current"].time[0] == 500e-9


def test_a_bags_own_file_is_enough(tmp_path):
    for storage, ending in (("mcap", "*.mcap"), ("sqlite3", "*.db3")):
        write_bag(tmp_path / storage, storage)
        [file] = (tmp_path / storage).glob(ending)
        [found] = import_source(file, model())
        assert np.array_equal(found.signals["position"].values, motion())


def test_a_bag_without_stamps_takes_those_of_the_host(tmp_path):
    write_bag(tmp_path / "bag", "mcap", stamped=False)
    [found] = import_source(tmp_path / "bag", model())
    np.testing.assert_allclose(found.signals["position"].time, TIME + np.arange(200) % 7 * 1e-6, atol=1e-9)


def test_a_bag_of_another_robot_is_refused(tmp_path):
    write_bag(tmp_path / "bag", "mcap", names=("axis1", "elbow"))
    with pytest.raises(ExidynError, match="has no joint 'axis2'. Valid joints: axis1, elbow"):
        import_source(tmp_path / "bag", model())


def test_a_bag_says_which_topics_it_has(tmp_path):
    write_bag(tmp_path / "bag", "mcap")
    with pytest.raises(
        RecordingError, match="no joint states on /states. Topics with joint states: /arm/joint_states"
    ):
        import_source(tmp_path / "bag", model(), topic="/states")


def test_a_broken_bag_is_refused_in_our_words(tmp_path):
    pytest.importorskip("rosbags")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("nonsense: [")
    with pytest.raises(NotAFile, match="cannot be read as a ROS 2 bag"):
        import_source(tmp_path / "bag", model())


def test_without_rosbags_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "run.db3").write_bytes(b"")
    assert kind_of(tmp_path / "run.db3") == "ros2_bag"
    with pytest.raises(RecordingError, match=r"pip install exidyn\[ros2\]"):
        import_source(tmp_path / "run.db3", model())
