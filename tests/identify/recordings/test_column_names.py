"""What names of columns say, which import and init read by the same words."""

import numpy as np
import pytest

from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.tables.column_names import families, joints_named, signal_of, unit_of
from exidyn.identification.recordings.tables.name_index import UNITS_ONLY, WORDS

from ...parts.small import two_joints


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("actual_q_", "position"),
        ("current_position", "position"),
        ("target_qd_", "command_velocity"),
        ("target_moment_", "other"),
        ("target_accelerations", "other"),
        ("target_positions", "command"),
        ("state.tau_J[]", "torque"),
        ("state.q_d[]", "command"),
        ("tau_ext_hat_filtered", "other"),
        ("JointVel", "velocity"),
        ("motor_current", "current"),
        ("actual_TCP_pose_", "other"),
        ("observation.state", "position"),
        ("action", "command"),
        ("temp", "temperature"),
        ("channel", ""),
    ],
)
def test_words_of_a_name_tell_the_signal(name, signal):
    assert signal_of(name) == signal


@pytest.mark.parametrize(
    ("name", "unit"), [("pos [deg]", "deg"), ("time_ms", "ms"), ("q_rad", "rad"), ("s", ""), ("t", "")]
)
def test_a_unit_stands_behind_the_quantity(name, unit):
    assert unit_of(name) == unit


def test_columns_are_grouped_by_the_names_of_joints():
    joints = ("shoulder", "elbow", "wrist_1")
    names = ["t", "elbow/pos", "wrist_1/pos", "shoulder/pos", "i1", "i2", "i3", "i4"]
    (found,) = families(names, joints)
    assert (found.pattern, found.places, found.by_name) == ("{joint}/pos", (3, 1, 2), True)
    joints = ("FL_hip_joint", "FL_calf_joint")
    (position, command) = families(["q_FL_hip", "q_FL_calf", "cmd_FL_hip", "cmd_FL_calf"], joints)
    assert (position.pattern, position.signal) == ("q_{joint}", "position")
    assert (command.pattern, command.signal) == ("cmd_{joint}", "command")
    assert [family.pattern for family in families(["q1", "q2"], ("joint_1", "joint_2"))] == ["q{number}"]
    names = [str(k) for k in range(1, 6)]
    assert [family.names for family in families(names, ("a", "b"))] == [("2", "3"), ("4", "5")]
    assert families([f"i{name}" for name in names], ("a", "b")) == []


def test_a_log_may_have_names_of_its_own_for_the_joints():
    joints, own = ("pan", "lift", "roll"), ("Rotation", "Pitch", "Roll")
    names = ["t", *(f"{signal}_{name}" for signal in ("cmd", "q", "abs_effort") for name in own)]
    found = [(family.signal, family.by_name) for family in families(names, joints)]
    assert found == [("command", False), ("position", False), ("torque", False)]  # in an unknown order
    forces = [f"{where}_{axis}" for where in ("force", "bias") for axis in "xyz"]
    assert families([*forces, "q1", "q2", "q3"], joints)[-1].names == ("q1", "q2", "q3")
    assert joints_named(names, joints) == list(joints)
    by_joint = ["J1 Position", "J1 Torque", "J2 Position", "J2 Torque"]
    assert families(by_joint, ("a", "b"))[0].names == ("J1 Position", "J2 Position")


def test_numbers_stand_for_joints():
    names = ["q_0", "q_1", "i1", "i2", "ch2", "ch3", "pose1", "pose2", "pose3"]
    assert [family.names for family in families(names, ("a", "b"))] == [("q_0", "q_1"), ("i1", "i2")]
    (found,) = families(["state1", "state2", "state3"], ("arm", "base"), ("base", "gripper", "arm"))
    assert found.names == ("state3", "state1")


@pytest.mark.parametrize("effort", [(), ("- elbow_effort", "- wrist_effort")])
def test_joints_of_which_a_file_has_positions_alone_are_told_from_those_it_does_not_have(effort):
    names = ["t", "- elbow_position", "- wrist_position", *effort]
    assert joints_named(names, ("wheel", "elbow", "wrist", "finger")) == ["elbow", "wrist"]


def test_units_of_joints_may_differ_in_names():
    names = ["t", "rail_pos [mm]", "arm_pos [deg]", "rail_torque [N]", "arm_torque [Nm]"]
    found = families(names, ("rail", "arm"))
    assert [(family.signal, family.unit, family.places) for family in found] == [
        ("position", "mm deg", (1, 2)),
        ("torque", "", (3, 4)),
    ]


PATTERNS = ("{joint}_{word}", "{word}_{joint}", "{word}{number}")
NAMED = [(signal, word) for signal, words in WORDS.items() for word in sorted(words - UNITS_ONLY)]


@pytest.mark.parametrize(
    ("signal", "word", "pattern"), [(*pair, PATTERNS[place % 3]) for place, pair in enumerate(NAMED)]
)
def test_every_word_names_its_signal(tmp_path, pattern, signal, word):
    model, time = two_joints.model(), np.arange(0.0, 1.0, 0.01)
    columns = {"t": time}
    random = np.random.default_rng(0)
    for place, joint in enumerate(model.robot.joints):
        usual = {"position": f"q{place + 1}", "torque": f"tau{place + 1}"}
        values = np.sin(time + place) if signal != "temperature" else 30.0 + 0.1 * time
        column = pattern.format(joint=joint, word=word, number=place + 1)
        for other, name in usual.items():
            if other != signal:
                columns[name] = random.normal(size=len(time)) if other == "torque" else np.sin(time + place)
        columns[column] = values
    path = tmp_path / "run.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns))
    [recording] = import_source(path, model)
    assert signal in recording.signals
    assert signal_of(f"{word} x") in (signal, "position")  # that of the words `q` and `pos` in two tables
