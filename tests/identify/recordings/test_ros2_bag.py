"""ROS 2 bags, written by another library."""

import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.errors import ExidynError, MissingPackage, NotAFile, NotRecorded, RecordingError
from exidyn.identification.recordings.importers import import_source, kind_of
from exidyn.identification.recordings.mcap.mcap_file import write_recording

from ...parts.runs.runs import TIME, model, motion, noise, require

pytestmark = pytest.mark.usefixtures("in_process")


def write_bag(
    folder: Path,
    storage: str,
    stamped: bool = True,
    names=("axis2", "axis1"),
    effort: bool = True,
    moved: bool = True,
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
            fields = (position, silent) if moved else (silent, position)
            message = state(header(stamp, ""), list(names), *fields, torque if effort else silent)
            host = 1_700_000_000_000_000_000 + moment + (k % 7) * 1000
            writer.write(states, host, store.serialize_cdr(message, state.__msgtype__))
            message = array(layout([], 0), noise(seed=5)[k])
            writer.write(currents, host + 500, store.serialize_cdr(message, array.__msgtype__))


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_is_read_by_the_names_of_the_joints(tmp_path, storage):
    write_bag(tmp_path / "bag", storage)
    [found] = import_source(tmp_path / "bag", model())
    require(found, position=motion(), torque=noise(), current=noise(seed=5))
    assert "velocity" not in found.signals
    require(found, time=TIME, atol=1e-9)
    assert found.host_time[0] == 1_700_000_000_000_000_000
    assert found.signals["current"].time[0] == 500e-9


def test_a_file_that_has_lost_its_metadata_is_read(tmp_path):
    write_bag(tmp_path / "bag", "sqlite3")
    [file] = (tmp_path / "bag").glob("*.db3")
    assert np.array_equal(import_source(file, model())[0].signals["position"].values, motion())
    [found] = import_source(file.rename(tmp_path / "run.db3"), model())
    require(found, position=motion(), torque=noise())


def test_a_bag_without_stamps_takes_those_of_the_host(tmp_path):
    write_bag(tmp_path / "bag", "mcap", stamped=False)
    [found] = import_source(tmp_path / "bag", model())
    require(found, time=TIME + np.arange(200) % 7 * 1e-6, atol=1e-9)


def test_a_bag_with_velocities_only_is_refused(tmp_path):
    write_bag(tmp_path / "bag", "mcap", moved=False)
    with pytest.raises(NotRecorded, match="the messages have no positions: .*; there: velocity, effort"):
        import_source(tmp_path / "bag", model())


def test_a_bag_of_another_robot_is_refused(tmp_path):
    write_bag(tmp_path / "bag", "mcap", names=("axis1", "elbow"))
    with pytest.raises(ExidynError, match="has no joint 'axis2'. Valid joints: axis1, elbow"):
        import_source(tmp_path / "bag", model())


def test_a_bag_lists_its_topics(tmp_path):
    write_bag(tmp_path / "bag", "mcap")
    with pytest.raises(
        RecordingError, match="no joint states on /states. Topics with joint states: /arm/joint_states"
    ):
        import_source(tmp_path / "bag", model(), topic="/states")


def test_a_broken_bag_is_refused_in_our_words(tmp_path):
    pytest.importorskip("rosbags")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("nonsense: [")
    with pytest.raises(NotAFile, match="cannot be read as a ROS bag"):
        import_source(tmp_path / "bag", model())


def test_without_rosbags_the_message_states_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "run.db3").write_bytes(b"")
    assert kind_of(tmp_path / "run.db3") == "ros2_bag"
    with pytest.raises(MissingPackage, match=r'needs rosbags, .*pip install "\.\[ros2\]"'):
        import_source(tmp_path / "run.db3", model())


def write_arms(folder: Path, topics: dict[str, list[list[str]]], every: bool = True) -> None:
    """A bag with messages of several lists of joints, at every moment all of them or one by turns."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    with rosbag2.Writer(folder, version=9) as writer:
        for topic, lists in topics.items():
            connection = writer.add_connection(topic, state.__msgtype__, typestore=store)
            for moment, stamp in enumerate(np.rint(TIME * 1e9).astype(np.int64).tolist()):
                for names in lists if every else [lists[moment % len(lists)]]:
                    rows = [np.array([moves(topic, name, k)[moment] for name in names]) for k in range(3)]
                    message = state(header(time(0, stamp), ""), names, *rows)
                    raw = store.serialize_cdr(message, state.__msgtype__)
                    writer.write(connection, 10**18 + stamp, raw)


def moves(topic: str, joint: str, kind: int) -> np.ndarray:
    """What a joint of an arm does: another motion for every joint, topic and field."""
    return np.sin(3.0 * TIME + len(topic) + sum(map(ord, joint)) + kind)


TWO_ARMS = [["left_axis1", "left_axis2"], ["right_axis2", "right_axis1", "gripper"]]


def test_one_arm_of_two_on_a_topic_is_chosen_by_its_joints(tmp_path):
    write_arms(tmp_path / "bag", {"/joint_states": TWO_ARMS})
    with pytest.raises(RecordingError, match=r"choose one by --joints 'left_\{joint\}', --joints 'right_"):
        import_source(tmp_path / "bag", model())
    for joints in ("right_{joint}", ["right_axis1", "right_axis2"]):
        [found] = import_source(tmp_path / "bag", model(), joints=joints, effort="current")
        for kind, signal in enumerate(("position", "velocity", "current")):
            for place, joint in enumerate(("right_axis1", "right_axis2")):
                expected = moves("/joint_states", joint, kind)
                assert np.array_equal(found.signals[signal].values[:, place], expected)
    [both] = import_source(tmp_path / "bag", model(), joints=["left_axis1", "right_axis2"])
    assert both.warnings[0].startswith("no message has all joints: left_axis1 on /joint_states (250 Hz) and")


def test_a_prefix_that_only_one_arm_has_need_not_be_given(tmp_path):
    write_arms(tmp_path / "bag", {"/joint_states": [["gripper"], ["ur_axis2", "ur_axis1"]]})
    [found] = import_source(tmp_path / "bag", model())
    assert np.array_equal(found.signals["torque"].values[:, 0], moves("/joint_states", "ur_axis1", 2))


def test_one_arm_of_two_is_chosen_by_its_topic(tmp_path):
    names = [["axis1", "axis2"]]
    write_arms(tmp_path / "bag", {"/left/joint_states": names, "/right/joint_states": names})
    with pytest.raises(RecordingError, match="states: /left/joint_states, /right/joint_states; choose"):
        import_source(tmp_path / "bag", model())
    [found] = import_source(tmp_path / "bag", model(), topic="/right/joint_states")
    assert np.array_equal(found.signals["position"].values[:, 1], moves("/right/joint_states", "axis2", 0))


def test_the_order_of_joints_may_change_from_message_to_message(tmp_path):
    write_arms(tmp_path / "bag", {"/joint_states": [["axis1", "axis2"], ["axis2", "axis1"]]}, every=False)
    [found] = import_source(tmp_path / "bag", model())
    for place, joint in enumerate(("axis1", "axis2")):
        assert np.array_equal(found.signals["torque"].values[:, place], moves("/joint_states", joint, 2))


@pytest.mark.parametrize("stamp", [-1, 2**63 - 1])
def test_a_time_stamp_that_no_clock_shows_is_refused(tmp_path, stamp):
    write_bag(tmp_path / "bag", "sqlite3")
    [file] = (tmp_path / "bag").glob("*.db3")
    with closing(sqlite3.connect(file)) as bag, bag:
        bag.execute("UPDATE messages SET timestamp = ? WHERE id = 7", (stamp,))
    with pytest.raises(RecordingError, match="time"):
        write_recording(import_source(tmp_path / "bag", model())[0], tmp_path / "run.mcap")
    assert not (tmp_path / "run.mcap").exists()
