"""exidyn simulate --against: two recordings of one motion, where they differ, and what follows from that."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.files import given_runs
from exidyn.identification.effects import JointSpring
from exidyn.identification.errors import DifferentRobot, RecordingError
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import model_text, read_model
from exidyn.identification.simulation.comparison import compare
from exidyn.identification.simulation.simulate import simulate
from exidyn.identification.text_table import WIDTH

from ...parts.small import two_joints
from ...parts.small.two_joint_files import of_another_arm, write

pytestmark = pytest.mark.slow

LATE = 1.2345
"""How much later the simulation's clock is [s]."""
PLANT = two_joints.model(JointSpring(("elbow",)))


def made(name: str, stiffness: float = 0.0, seed: int = 1, rate: float = 250.0, **more: float) -> Recording:
    """A run of the two-joint arm with a spring at its elbow."""
    motion = two_joints.trajectory(20.0, 0).at(np.arange(0.0, 20.0, 1.0 / rate))
    values = dict(zip(PLANT.names, two_joints.true_values(PLANT), strict=True)) | {"Ks2": stiffness} | more
    given = np.array([values[name] for name in PLANT.names])
    return simulate(PLANT, given, two_joints.GAIN, motion, two_joints.model(), name=name, seed=seed)


def late(recording: Recording, by: float = LATE) -> Recording:
    signals = {name: Signal(one.time + by, one.values) for name, one in recording.signals.items()}
    return replace(recording, signals=signals)


def as_torque(recording: Recording) -> Recording:
    """As another simulator writes it: torque in place of current."""
    signals = dict(recording.signals)
    current = signals.pop("current")
    return replace(
        recording, signals={**signals, "torque": Signal(current.time, current.values * two_joints.GAIN)}
    )


def test_noise_is_all_that_distinguishes_two_runs_of_one_arm():
    found = compare(made("sim", seed=1), made("real", seed=2))
    np.testing.assert_allclose(
        found.effort.rms / found.effort.noise, 1.0, atol=0.5
    )  # a short rest gives noise to a third
    assert found.effort.quantity == "current"
    assert found.effort.units == ("A", "A")
    assert found.warnings == ()


def test_a_spring_is_seen_in_current_on_its_joint_away_from_the_middle():
    real = made("real", 12.0, seed=2)
    found = compare(made("sim"), real)
    over = found.effort.rms / found.effort.noise
    assert over[0] < 1.5
    assert over[1] > 5.0
    time, angle = found_positions(found, real)
    expected = np.sqrt(np.mean((12.0 * angle / two_joints.GAIN[1]) ** 2))
    assert found.effort.rms[1] == pytest.approx(expected, rel=0.15)
    regions = found.effort.regions["position"]
    assert np.argmin(regions.rms[1]) == 1
    edges = np.quantile(angle, [0.0, 1 / 3, 2 / 3, 1.0])
    np.testing.assert_allclose(regions.edges[1], edges, atol=0.1)


def found_positions(found, real):
    """Time and angle of the elbow over the middle of a run."""
    position = real.signals["position"]
    inside = (position.time > 1.0) & (position.time < position.time[-1] - 1.0)
    return position.time[inside], position.values[inside, 1]


def test_friction_is_seen_alike_at_all_speeds_and_its_viscous_part_at_high_ones():
    real = made("real", seed=2)
    viscous = compare(made("sim", Fv2=3.0), real).effort.regions["speed"].rms[1]
    assert viscous[2] > 1.8 * viscous[1] > 1.8 * 1.3 * viscous[0]
    dry = compare(made("sim", Fc2=4.0), real).effort.regions["speed"].rms[1]
    assert np.ptp(dry) < 0.35 * np.mean(dry)


def test_positions_that_differ_are_reported_to_the_size():
    real = made("real", seed=2)
    signals = dict(made("sim").signals)
    signals["position"] = Signal(
        signals["position"].time, signals["position"].values + np.array([0.0, 0.003])
    )
    found = compare(replace(made("sim"), signals=signals), real)
    np.testing.assert_allclose(found.mismatch["position"].mean, [0.0, 0.003], atol=1e-4)
    np.testing.assert_allclose(found.mismatch["position"].rms, [0.0, 0.003], atol=2e-4)


def test_torque_of_a_simulator_and_current_of_a_controller_meet_as_torque():
    real = made("real", seed=2)
    found = compare(as_torque(made("sim")), real)
    assert found.effort.quantity == "torque"
    same = compare(made("sim"), real)
    np.testing.assert_allclose(found.effort.rms, same.effort.rms * np.abs(two_joints.GAIN), rtol=0.1)
    unknown = replace(real, model=replace(real.model, robot=replace(real.robot, drive_gain=np.ones(2))))
    assert "no drive gain that converts" in compare(as_torque(made("sim")), unknown).warnings[0]


def test_a_slower_simulation_is_compared_up_to_where_it_goes():
    sim = made("sim")
    time = np.arange(0.003, 19.9, 0.01)
    signals = {
        name: Signal(time, CubicSpline(one.time, one.values)(time)) for name, one in sim.signals.items()
    }
    found = compare(replace(sim, signals=signals), made("real", seed=2))
    assert found.filter_hz < 50.0
    assert np.all(found.effort.rms < 2.0 * found.effort.noise)


def test_runs_that_differ_too_much_are_warned_of_or_refused():
    found = compare(replace(made("sim"), payload=KnownPayload("L", (("M", 3.0),))), made("real"))
    assert found.warnings == ("sim carries L, M 3, but real carries no payload",)
    with pytest.raises(RecordingError, match=r"overlap for .* filters at .* state the offset"):
        compare(late(made("sim"), 30.0), made("real"))
    other = made("real")
    robot = two_joints.arm()
    robot = replace(robot, kinematics=robot.kinematics.copy())
    robot.kinematics.names[1] = "hip"
    with pytest.raises(DifferentRobot, match="give the joints the same names"):
        compare(made("sim"), replace(other, model=Model(robot, other.model.effects)))


def against(simulated: str, recorded: str, *options: str) -> int:
    return main(["simulate", simulated, "--against", recorded, *options])


@pytest.fixture
def files(tmp_path):
    """Paths of a simulation that has a spring in its model, and of a run without."""
    nominal = two_joints.model(JointSpring(("elbow",)))
    return write(tmp_path, late(replace(made("sim", 12.0), model=nominal)), made("real", seed=2))


def test_page_names_the_joint_aligns_the_clocks_and_goes_on(files, tmp_path, capsys):
    path = tmp_path / "compared.json"
    assert against(*files, "--json", str(path)) == 0
    page, text = capsys.readouterr()
    assert max(map(len, page.splitlines())) <= WIDTH
    assert "- elbow: current differs by" in page
    assert "- shoulder" not in page
    assert f"sim shifted by -{LATE:.4f} s" in page
    table = json.loads(path.read_text())
    assert table["offset"] == pytest.approx(-LATE, abs=1e-3)
    sim, real = files
    model = sim.replace(".mcap", "-model.toml")
    made_next = [f"exidyn export {sim} --to toml -o {model}", f"exidyn diagnose {real} --robot {model}"]
    assert table["go_on"] == made_next
    assert text.splitlines() == [f"written: {path}", *(f"next: {line}" for line in made_next)]


def test_what_is_printed_as_next_can_be_run(files, tmp_path, capsys):
    assert against(*files) == 0
    export = next(line for line in capsys.readouterr().err.splitlines() if "exidyn export" in line)
    assert main(export.split()[2:]) == 0
    assert "Ks2" in read_model(export.split()[-1]).names


def test_same_models_need_no_export(tmp_path, capsys):
    files = write(tmp_path, made("sim", 12.0), made("real", seed=2))
    assert against(*files) == 0
    assert capsys.readouterr().err == f"next: exidyn diagnose {files[1]}\n"
    robot = tmp_path / "robot.toml"
    robot.write_text(model_text(two_joints.model()))
    assert against(*files, "--robot", str(robot)) == 0
    assert capsys.readouterr().err == f"next: exidyn diagnose {files[1]} --robot {robot}\n"


def test_two_runs_alike_leave_nothing_to_diagnose(tmp_path, capsys):
    files = write(tmp_path, made("sim"), made("real", seed=2))
    assert against(*files, "--offset", "0") == 0
    assert "No joint's current differs by more than noise" in capsys.readouterr().out


def test_motion_that_repeats_itself_is_a_warning(tmp_path, capsys):
    runs = []
    for name in ("sim", "real"):
        one = made(name)
        time = one.signals["position"].time
        turning = np.sin(2 * np.pi * time / 4.0)[:, None] * np.array([0.5, 0.3])
        runs.append(replace(one, signals={**one.signals, "position": Signal(time, turning)}))
    assert against(*write(tmp_path, *runs)) == 0
    page = " ".join(capsys.readouterr().out.split())
    assert "4.00 s further, since the motion repeats itself; state the offset of the clocks" in page


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{sim}", "missing.mcap"], "missing.mcap does not exist"),
        (["{sim}", "{case}"], "holds 0 recordings"),
        (["{sim}", "{real}", "--offset", "100"], "overlap for 0.00 s"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(arguments, message, files, tmp_path, capsys, monkeypatch):
    read = given_runs.import_source
    monkeypatch.setattr(
        given_runs, "import_source", lambda path, model: [] if path.is_dir() else read(path, model)
    )
    names = dict(zip(("sim", "real"), files, strict=True)) | {"case": tmp_path}
    assert against(*(one.format(**names) for one in arguments)) == REFUSED
    [line] = capsys.readouterr().err.splitlines()
    assert message in line


def test_another_arm_is_compared_by_its_joints(tmp_path):
    other = tmp_path / "other.mcap"
    write_recording(of_another_arm(made("real", seed=2)), other)
    (sim,) = write(tmp_path, made("sim"))
    assert against(sim, str(other)) == 0
