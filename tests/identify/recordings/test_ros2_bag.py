"""ROS 2 bags, written by another library."""

import sys
from pathlib import Path

import numpy as np
import pytest

from exidyn.identify.errors import ExidynError, NotAFile, RecordingError
from exidyn.identify.recordings.importers import import_source, kind_of

from ...parts.runs.runs import TIME, model, motion, noise


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
    with pytest.raises(NotAFile, match="cannot be read as a ROS 2 bag"):
        import_source(tmp_path / "bag", model())


def test_without_rosbags_the_message_states_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "run.db3").write_bytes(b"")
    assert kind_of(tmp_path / "run.db3") == "ros2_bag"
    with pytest.raises(RecordingError, match=r'pip install "\.\[ros2\]"'):
        import_source(tmp_path / "run.db3", model())
