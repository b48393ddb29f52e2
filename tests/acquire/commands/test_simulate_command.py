"""exidyn simulate and export: what they write, print and refuse."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import exidyn as ex
from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import Payload, Prior, RotorInertia, known_parameters
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import model_text, parse_model
from exidyn.identification.simulation.simulate import exact_current
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan

from ...parts.plans.plans import fourier
from ...parts.small import two_joints
from ...parts.small.small_fit import fit

pytestmark = pytest.mark.slow

MOTION = fourier(periods=1).scaled(0.5)
BODY = known_parameters(3.0, (0.05, 0.0, 0.02))
TICK = "0.004"


def arm() -> Model:
    model = two_joints.model(RotorInertia(), Payload("tool", BODY))
    return replace(model, stated={"Ia1": Prior(0.5), "Ia2": Prior(0.2)})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder, the current one, with robot.toml, plan.toml and fit.json."""
    (tmp_path / "robot.toml").write_text(model_text(arm()))
    write_plan(Plan.of(MOTION, two_joints.model()), tmp_path / "plan.toml")
    write_fit(fit(), tmp_path / "fit.json")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def simulate(*arguments, plan="plan.toml", output="sim.mcap", source="robot.toml"):
    return main(["simulate", source, plan, "-o", output, "--tick", TICK, *arguments])


def test_a_simulation_is_a_recording(folder, capsys):
    assert simulate() == 0
    printed, text = capsys.readouterr()
    assert "times real time" in printed
    assert "largest deviation from the command: shoulder" in printed
    assert "written: sim.mcap" in text
    run = read_recording("sim.mcap")
    names = {"position", "velocity", "current", "temperature", "command", "command_velocity"}
    assert set(run.signals) == names
    assert run.robot.joints == ("shoulder", "elbow")
    assert run.trajectory == (folder / "plan.toml").read_text(encoding="utf-8")
    position, command = (run.signals[name].values for name in ("position", "command"))
    assert np.abs(position - command).max() < 0.02
    assert np.ptp(position, axis=0).min() > 0.05
    assert run.signals["position"].rate == pytest.approx(250.0)
    assert not run.warnings
    # from rest, though the motion of the plan begins moving, to rest
    for ends in (command[:3], command[-3:]):
        assert np.abs(np.diff(ends, axis=0)).max() < 1e-4, np.diff(ends, axis=0)


def exact(model: Model, **options) -> Recording:
    """A simulation with sensors that add nothing, by the library."""
    return ex.simulate(model, Plan.of(MOTION, two_joints.model()), tick=float(TICK), exact=True, **options)


def test_currents_are_those_of_the_model_with_what_it_carries():
    run = exact(arm(), payload=KnownPayload("tool", BODY))
    assert current_error(run, run.model) < 0.01
    assert current_error(replace(run, payload=None), run.model) > 0.05


def current_error(run, model):
    """Rms of recorded current minus inverse dynamics of the recorded positions, over the rms current."""
    position = run.signals["position"]
    spline = make_interp_spline(position.time, position.values, 5)
    states = [spline(position.time, order) for order in range(3)]
    motion = Motion.of(position.time, *states, payload=run.payload.name if run.payload else "")
    expected = exact_current(model, model.nominal_values, model.robot.drive_gain, motion)
    inside = slice(50, -50)
    wrong = (run.signals["current"].values - expected)[inside]
    return np.sqrt(np.mean(wrong**2) / np.mean(expected[inside] ** 2))


def test_the_same_arguments_give_the_same_file(folder):
    for output, seed in (("one/run.mcap", "3"), ("two/run.mcap", "3"), ("three/run.mcap", "4")):
        (folder / output).parent.mkdir()
        assert simulate("--seed", seed, output=output) == 0
    one, two, three = ((folder / name / "run.mcap").read_bytes() for name in ("one", "two", "three"))
    assert one == two
    assert one != three


def test_a_fit_is_simulated_as_identified(folder):
    assert simulate(source="fit.json") == 0
    run, found = read_recording("sim.mcap"), identified(fit())
    np.testing.assert_array_equal(run.robot.drive_gain, found.robot.drive_gain)
    assert current_error(exact(found), found) < 0.01


def test_elastic_gears_show_behind_them():
    run = exact(arm(), stiffness=[2000.0, np.inf], damping=2.0)
    twist = np.ptp(run.signals["position"].values - run.signals["link_position"].values, axis=0)
    assert twist[0] > 1e-3
    assert twist[1] < 1e-9


def test_half_the_speed_takes_twice_the_time_and_a_payload_is_in_the_recording(folder):
    assert simulate() == 0
    whole = read_recording("sim.mcap").duration
    assert simulate("--speed", "50") == 0
    longer = read_recording("sim.mcap").duration
    assert longer - whole == pytest.approx(MOTION.duration, abs=1.0)
    assert simulate("--payload", "tool") == 0
    assert read_recording("sim.mcap").payload == KnownPayload("tool", BODY)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--payload", "gripper"], "no payload 'gripper'. Payloads of the model: tool"),
        (["--com", "0", "0", "0.1"], "give --mass"),
        (["--mass", "2", "--payload", "tool"], "not both"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_line(folder, capsys, arguments, message):
    assert simulate(*arguments) == REFUSED
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert simulate(source="kr270") == REFUSED
    assert "the plan is for the joints shoulder, elbow" in capsys.readouterr().err
    assert not (folder / "sim.mcap").exists()


def test_export_writes_and_reports_what_is_missing(folder, capsys):
    assert main(["export", "fit.json", "--to", "urdf", "-o", "arm.urdf"]) == 0
    printed, text = capsys.readouterr()
    assert printed.startswith("urdf cannot represent:\n  - ")
    assert "friction_asymmetry: up to" in printed
    assert text == "written: arm.urdf\n"
    assert (folder / "arm.urdf").read_text().startswith('<?xml version="1.0"?>')


def test_export_to_a_robot_file_leaves_nothing_out(folder, capsys):
    assert main(["export", "fit.json", "--to", "toml"]) == 0
    assert capsys.readouterr().out == "toml represents everything\n"
    back = parse_model((folder / "two_joints-export.toml").read_text())
    np.testing.assert_allclose(back.nominal_values, identified(fit()).nominal_values, rtol=1e-9, atol=1e-9)
    before = (folder / "robot.toml").read_text()
    assert main(["export", "robot.toml", "--to", "toml", "-o", "robot.toml"]) == REFUSED
    assert "--output would overwrite a file that is read; name another" in capsys.readouterr().err
    assert (folder / "robot.toml").read_text() == before


def test_export_of_a_recording_is_a_table_that_import_reads(folder, capsys):
    simulate()
    capsys.readouterr()
    run = read_recording("sim.mcap")
    for form in ("csv", "parquet"):
        if form == "parquet":
            pytest.importorskip("pyarrow")
        assert main(["export", "sim.mcap", "--to", form]) == 0
        assert f"{form} cannot represent:\n  - the robot and its nominal values" in capsys.readouterr().out
        assert main(["import", f"sim-export.{form}", "--robot", "robot.toml", "-o", f"{form}.mcap"]) == 0
        back = read_recording(f"{form}.mcap")
        for name, signal in run.signals.items():
            assert np.array_equal(back.signals[name].values, signal.values)
    assert main(["export", "robot.toml", "--to", "csv"]) == REFUSED
