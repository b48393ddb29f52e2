"""Bags with the states of ros2_control instead of joint states."""

import numpy as np
import pytest

from exidyn.identification.recordings.importers import import_source

from ...parts.runs import bags
from ...parts.runs.bags import sent
from ...parts.runs.runs import model

pytestmark = pytest.mark.usefixtures("in_process")

NAMES = ("axis2", "axis1")
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
    [found] = import_source(write(tmp_path / "bag", sent(NAMES), DYNAMIC, dynamic, types(DYNAMIC)), model())
    require_signals(found)


@pytest.mark.parametrize("fields", [("desired", "actual"), ("reference", "feedback")])
def test_states_of_a_trajectory_controller_have_commands(tmp_path, fields):
    store = types(CONTROLLER, fields)
    [found] = import_source(write(tmp_path / "bag", sent(NAMES), CONTROLLER, controller, store), model())
    require_signals(found)
    commanded = found.signals["command"].values
    np.testing.assert_allclose(commanded, found.signals["position"].values + 0.01, atol=1e-6)
