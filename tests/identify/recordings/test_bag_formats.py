"""Bags of ROS 1, MCAP files in the encodings that people have, and states of ros2_control."""

import numpy as np
import pytest

from exidyn.identification.errors import NotAFile
from exidyn.identification.recordings.importers import import_source, kind_of

from ...parts.runs import bags
from ...parts.runs.bags import sent
from ...parts.runs.runs import model

pytestmark = pytest.mark.usefixtures("in_process")

NAMES = ("axis2", "gripper", "axis1")


def require_whole(recording, count=300):
    """The run is what was sent."""
    signals = recording.signals
    assert len(signals["position"]) == count
    assert recording.warnings == ()
    for signal, what in (("position", bags.moves), ("velocity", bags.turns), ("torque", bags.pulls)):
        for joint, name in enumerate(("axis1", "axis2")):
            expected = [what(name, time) for time in signals[signal].time]
            np.testing.assert_allclose(signals[signal].values[:, joint], expected, atol=1e-6)
    assert recording.host_time[0] == bags.START


def test_a_bag_of_ros_1_is_read(tmp_path):
    path = bags.write_ros1(tmp_path / "run.bag", sent(NAMES))
    assert kind_of(path) == "ros2_bag"
    [found] = import_source(path, model())
    require_whole(found)


@pytest.mark.parametrize(("encoding", "profile"), [("ros1", ""), ("cdr", "ros1"), ("cdr", "ros2")])
def test_messages_of_ros_in_mcap_are_read_whatever_the_profile(tmp_path, encoding, profile):
    path = bags.write_mcap(tmp_path / "run.mcap", sent(NAMES), encoding, bags.as_ros(encoding), profile)
    [found] = import_source(path, model())
    require_whole(found)


@pytest.mark.parametrize("stamp", [("sec", "nsec"), ("secs", "nsecs"), ("sec", "nanosec")])
def test_joint_states_in_json_are_read(tmp_path, stamp):
    pytest.importorskip("rosbags")
    path = bags.write_mcap(tmp_path / "run.mcap", sent(NAMES), "json", bags.as_json(stamp))
    [found] = import_source(path, model())
    require_whole(found)


def test_joints_as_a_list_of_objects_in_json_are_read(tmp_path):
    pytest.importorskip("rosbags")

    def data(message):
        rows = zip(message.names, message.position, message.velocity, message.effort, strict=True)
        keys = ("name", "position", "velocity", "effort")
        joints = [dict(zip(keys, row, strict=True)) for row in rows]
        sec, nsec = divmod(message.stamp, 10**9)
        return bags.json.dumps({"timestamp": {"sec": sec, "nsec": nsec}, "joints": joints}).encode()

    form = ("foxglove.JointStates", "jsonschema", b"{}", data)
    [found] = import_source(bags.write_mcap(tmp_path / "run.mcap", sent(NAMES), "json", form), model())
    require_whole(found)


def test_of_a_file_that_was_cut_off_what_is_there_is_read(tmp_path):
    path = bags.write_mcap(tmp_path / "run.mcap", sent(NAMES), "cdr", bags.as_ros("cdr"), "ros2")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    [found] = import_source(path, model())
    assert 50 < len(found.signals["position"]) < 250
    assert found.warnings[0].startswith(
        "run.mcap ends abruptly: its recorder crashed or its copy was cut off."
    )


def test_a_file_without_joint_states_lists_what_it_has(tmp_path):
    pytest.importorskip("rosbags")
    form = ("robot.State", "protobuf", b"", lambda message: b"\x0a")
    path = bags.write_mcap(tmp_path / "run.mcap", sent(NAMES), "protobuf", form)
    with pytest.raises(NotAFile, match=r"no joint states .*: /joint_states \(robot.State in protobuf\)"):
        import_source(path, model())


def test_a_bag_of_ros_1_whose_recorder_crashed_says_what_to_do(tmp_path):
    path = bags.write_ros1(tmp_path / "run.bag", sent(NAMES)).rename(tmp_path / "run.bag.active")
    whole = path.read_bytes()
    assert b"index_pos=" in whole
    place = whole.index(b"index_pos=") + len(b"index_pos=")  # which is written last
    path.write_bytes(whole[:place] + bytes(8) + whole[place + 8 :])
    with pytest.raises(NotAFile, match="Bag is not indexed, reindex"):
        import_source(path, model())


CONTROLLED = ("axis2", "axis1")
DYNAMIC = "control_msgs/msg/DynamicJointState"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
LINE = "=" * 80
DEFINITIONS = {
    DYNAMIC: f"""std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
{LINE}
MSG: control_msgs/InterfaceValue
string[] interface_names
float64[] values
""",
    CONTROLLER: """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint FIRST
trajectory_msgs/JointTrajectoryPoint SECOND
trajectory_msgs/JointTrajectoryPoint error
""",
}


def types(kind, fields=("", "")):
    """The types of ROS 2 with one more, whose fields may have other names."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    text = DEFINITIONS[kind].replace("FIRST", fields[0]).replace("SECOND", fields[1])
    store.register(typesys.get_types_from_msg(text, kind))
    return store


def header(store, message):
    time = store.types["builtin_interfaces/msg/Time"](*divmod(message.stamp, 10**9))
    return store.types["std_msgs/msg/Header"](time, "")


def dynamic(store, message):
    value = store.types["control_msgs/msg/InterfaceValue"]
    rows = zip(message.position, message.velocity, message.effort, strict=True)
    # As of two makers: each joint has its interfaces in another order, and a sensor has others.
    joints = [(["position", "velocity", "effort"], [q, dq, tau]) for q, dq, tau in rows]
    joints[0] = ([*reversed(joints[0][0])], [*reversed(joints[0][1])])
    values = [value(names, np.array(numbers)) for names, numbers in [*joints, (["force.x"], [9.0])]]
    return store.types[DYNAMIC](header(store, message), [*message.names, "tcp_sensor"], values)


def controller(store, message):
    point, duration = (
        store.types[name]
        for name in ("trajectory_msgs/msg/JointTrajectoryPoint", "builtin_interfaces/msg/Duration")
    )
    nothing, zero = np.empty(0), duration(0, 0)
    arrays = [np.array(values) for values in (message.position, message.velocity, message.effort)]
    commanded = point(arrays[0] + 0.01, arrays[1], nothing, nothing, zero)
    measured = point(arrays[0], arrays[1], nothing, arrays[2], zero)
    return store.types[CONTROLLER](
        header(store, message), list(message.names), commanded, measured, commanded
    )


def write(path, messages, kind, content, store):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    with rosbag2.Writer(path, version=9) as writer:
        connection = writer.add_connection("/states", kind, typestore=store)
        for message in messages:
            raw = store.serialize_cdr(content(store, message), kind)
            writer.write(connection, message.received, raw)
    return path


def require_signals(recording):
    time = recording.signals["position"].time
    for signal, what in (("position", bags.moves), ("velocity", bags.turns), ("torque", bags.pulls)):
        expected = [[what(name, moment) for name in ("axis1", "axis2")] for moment in time]
        np.testing.assert_allclose(recording.signals[signal].values, expected, atol=1e-6)
    assert recording.warnings == ()


def test_states_of_interfaces_are_read(tmp_path):
    [found] = import_source(
        write(tmp_path / "bag", sent(CONTROLLED), DYNAMIC, dynamic, types(DYNAMIC)), model()
    )
    require_signals(found)


@pytest.mark.parametrize("fields", [("desired", "actual"), ("reference", "feedback")])
def test_states_of_a_trajectory_controller_have_commands(tmp_path, fields):
    store = types(CONTROLLER, fields)
    [found] = import_source(write(tmp_path / "bag", sent(CONTROLLED), CONTROLLER, controller, store), model())
    require_signals(found)
    commanded = found.signals["command"].values
    np.testing.assert_allclose(commanded, found.signals["position"].values + 0.01, atol=1e-6)
