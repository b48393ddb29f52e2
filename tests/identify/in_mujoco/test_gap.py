"""The gap between a simulation and an arm that has more than its file: what closes it, and what does not."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.effects import Prior, StribeckFriction
from exidyn.identification.errors import RecordingError, RobotError
from exidyn.identification.in_mujoco.distances import JOINTS, Distances, Gain, Judge
from exidyn.identification.in_mujoco.mujoco_laws import lead, servo_torque
from exidyn.identification.in_mujoco.replay import what_is_commanded
from exidyn.identification.pages.gap_document import Compared
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.servo_error import LAW, servo_of, servo_words, with_servo_error
from exidyn.mujoco import attach

from ...parts import servo_arms

mujoco = pytest.importorskip("mujoco")

ARM = servo_arms.ARM.replace('timestep="0.001"', 'timestep="0.002"')
PENDULUM = """<mujoco>
  <option timestep="0.002" integrator="{}" gravity="0 0 0"/>
  <worldbody>
    <body>
      <inertial mass="1" pos="0 0 0" diaginertia="0.1 0.1 0.1"/>
      <joint name="pivot" axis="0 1 0"/>
    </body>
  </worldbody>
  <actuator><position joint="pivot" kp="50" kv="5"/></actuator>
</mujoco>
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "commands", ["position", *(pytest.param(name, marks=pytest.mark.long) for name in ("torque", "alone"))]
)
def test_what_a_file_lacks_is_found_written_and_gains_on_a_run_held_out(
    commands, tmp_path, monkeypatch, capsys
):
    concealed = pytest.importorskip("parts.simulator.concealed")
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(ARM)
    nominal = concealed.described(Path("arm.xml"))
    real = concealed.with_effects(nominal, (StribeckFriction(joints=("elbow",), fade=0.15), 2.0))
    stated = dict(real.stated) | {"Fc1": Prior(3.0), "Fc2": Prior(1.0)}
    case = concealed.Case("two", Path("arm.xml"), nominal, concealed.replace(real, stated=stated), ())
    for seed, name in enumerate(("one", "other")):
        log = concealed.record(case, 16.0, seed, name)
        if commands == "alone":
            servo = servo_of(log.robot, None, None)
            signals = with_servo_error(log.signals, servo, name)
            settings = {LAW: servo_words(servo)}
            log = concealed.replace(log, signals=signals, settings=settings)
        write_recording(log, f"{name}.mcap")
    arguments = ["gap", "arm.xml", "one.mcap", "--validate", "other.mcap"]
    arguments += [] if commands == "alone" else ["--commands", commands]
    assert main([*arguments, "--full", "--json", "gap.json"]) == 0
    assert "Gain by stage" in capsys.readouterr().out
    table = json.loads(Path("gap.json").read_text())
    kept = [stage["name"].split(" of ")[0] for stage in table["stages"] if stage["kept"]]
    assert kept[-1] == "Stribeck friction"
    assert table["servos"] == []
    assert [finding["effect"] for finding in table["findings"]] == ["stribeck_friction"]
    assert table["commands"] == ("torque" if commands == "torque" else "position")
    original, file, attached = (table[key]["tool"][1] for key in ("original", "file", "attached"))
    assert attached < 0.3 * original
    assert file <= original
    written = mujoco.MjModel.from_xml_path(table["attached"]["written"])
    assert written.dof_armature.min() > 0.0
    data = mujoco.MjData(written)
    with attach(written, data, table["attached"]["effects"]) as effects:  # one arm, in the file and beside it
        assert "stribeck_friction" in effects.effects
    mujoco.MjModel.from_xml_path(table["file"]["written"])
    assert "<svg" in Path("exidyn-gap/report.html").read_text()


def distances(*ends, moved=10.0):
    """Distances of two starts: a row of joint errors for each horizon; the tool point's are ones."""
    rows = np.atleast_2d(np.array(ends, float))
    every = np.stack([rows, rows])
    return Distances(
        every, np.ones((2, len(rows))), np.ones(rows.shape[1]), 1.0, (), np.full(rows.shape, moved)
    )


def test_the_tool_point_judges_with_the_scatter_of_the_starts():
    rng, judge, base = np.random.default_rng(2), Judge(), distances(1.0, 1.0)
    errors = 0.01 * rng.uniform(0.5, 1.5, (40, 1))
    first = base._replace(tools=errors)
    assert judge.compared(first, base._replace(tools=0.8 * errors)) is Gain.BETTER
    assert judge.compared(first, base._replace(tools=1.2 * errors)) is Gain.WORSE
    assert judge.compared(first, base._replace(tools=0.97 * errors)) is Gain.SAME  # too little to matter
    one_start = np.where(np.arange(40)[:, None] == 0, 0.0, errors)
    assert judge.compared(first, base._replace(tools=one_start)) is Gain.SAME  # one start in forty
    assert judge.compared(first, base._replace(tools=np.full((40, 1), np.inf))) is Gain.WORSE


def test_joints_judge_if_requested_or_if_the_tool_point_is_on_their_axes():
    first, second = distances(1.0, 1.0), distances(0.4, 1.03)
    assert Judge().compared(first, second) is Gain.SAME
    assert Judge(JOINTS).compared(first, second) is Gain.BETTER  # 3 % on the second do not outweigh that
    on_axis = first._replace(tools=np.zeros((2, 1)))
    assert Judge().compared(on_axis, second) is Gain.BETTER


def test_an_error_larger_than_the_motion_is_not_informative():
    first = distances([0.5, 2.0], [9.0, 11.0], moved=10.0)
    assert list(first.telling) == [1, 0]
    # The second joint is judged by the shortest time, at which it is nearer.
    assert Judge(JOINTS).compared(first, distances([0.4, 1.0], [8.0, 12.0])) is Gain.BETTER


def test_a_log_of_commands_alone_has_the_torque_of_the_files_servos():
    model = mujoco.MjModel.from_xml_string(ARM.replace('kp="400"', 'kp="400" forcerange="-50 50"'))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = (0.1, 0.2), (0.3, -0.4), (0.15, 0.4)
    mujoco.mj_forward(model, data)
    found = servo_torque(model, [0, 1], data.ctrl[None] - data.qpos, data.qvel[None])
    np.testing.assert_allclose(found[0], data.qfrc_actuator, rtol=1e-12)
    assert data.qfrc_actuator[1] == 50.0


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_damping_of_servos_is_taken_as_the_integrator_takes_it(integrator):
    model = mujoco.MjModel.from_xml_string(PENDULUM.format(integrator))
    data, time = mujoco.MjData(model), np.arange(0.0, 4.0, 0.002)
    command, position = 0.5 * np.sin(2.0 * time) + 0.3 * np.sin(5.1 * time), np.empty_like(time)
    for row, one in enumerate(command):
        position[row], data.ctrl[0] = data.qpos[0], one
        mujoco.mj_step(model, data)
    velocity = np.gradient(position, time)
    acceleration = np.gradient(velocity, time)
    ahead = (velocity + lead(model) * acceleration)[:, None]
    torque = servo_torque(model, [0], (command - position)[:, None], ahead)[:, 0]
    moved = np.column_stack([acceleration, velocity])[500:-2]
    inertia = np.linalg.lstsq(moved, torque[500:-2], rcond=None)[0][0]
    assert inertia == pytest.approx(0.1, abs=3e-4)  # half a step of the damping is 0.005


def test_positions_are_commanded_where_file_and_runs_have_that():
    model = mujoco.MjModel.from_xml_string(ARM)
    motors = mujoco.MjModel.from_xml_string(ARM.replace("<position", "<motor").replace('kp="800" kv="40"', "")
                                            .replace('kp="400" kv="20"', ""))  # fmt: skip
    silent, joints = SimpleNamespace(name="one", signals={}), ("shoulder", "elbow")
    run = SimpleNamespace(name="two", signals={"command": None})
    assert what_is_commanded(model, [run], joints) == "position"
    assert what_is_commanded(model, [run, silent], joints) == "torque"
    assert what_is_commanded(motors, [run], joints) == "torque"
    with pytest.raises(RecordingError, match="one has no commanded positions"):
        what_is_commanded(model, [silent], joints, "position")
    with pytest.raises(RobotError, match="lacks position servos for some joints"):
        what_is_commanded(motors, [run], joints, "position")


def test_a_run_that_judges_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(ARM)
    rows = "\n".join(f"{0.01 * k},0,0,0,0" for k in range(100))
    Path("log.csv").write_text(f"t,q1,q2,tau1,tau2\n{rows}\n")
    assert main(["gap", "arm.xml", "log.csv"]) != 0
    assert "no run is held out" in capsys.readouterr().err


def test_a_tool_point_on_the_axis_says_nothing_and_the_farthest_joint_is_compared():
    ends = np.array([[[0.01, 0.3]], [[0.02, 0.4]]])
    before = Distances(ends, np.zeros((2, 1)), np.array([0.1, 0.2]), 0.0, (), np.ones((1, 2)))
    gap = SimpleNamespace(original=before, diagnosis=SimpleNamespace(joints=("one", "two")))
    compared = Compared.of(gap)
    assert (compared.name, compared.unit) == ("joint two", "mrad")
    assert compared.values(before) == pytest.approx([np.sqrt(0.125), 0.2])
    assert compared.far(before) == "354 mrad"
    away = before._replace(tools=np.full((2, 1), 0.003), whole_tool=0.004)
    compared = Compared.of(SimpleNamespace(original=away, diagnosis=gap.diagnosis))
    assert compared.values(away) == pytest.approx([0.003, 0.004])
    assert compared.far(away) == "3.00 mm"


@pytest.mark.long
def test_play_in_a_gear_is_written_as_structure_and_gains():
    gears = pytest.importorskip("parts.simulator.gears")
    answer = gears.answered(gears.CASES["play of 6 mrad"])
    assert answer["written"] == pytest.approx(0.006, rel=0.05)
    _, by_numbers, with_play = answer["distances"]
    assert with_play < 0.5 * by_numbers
