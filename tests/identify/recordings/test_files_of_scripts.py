"""Files that people's scripts write: NumPy arrays, JSON lines, a row per motor, and bags of own messages."""

import json

import numpy as np
import pytest

from exidyn.identification.errors import NotAFile
from exidyn.identification.recordings.importers import import_source, read_tables

from ...parts.runs import bags
from ...parts.runs.bags import sent
from ...parts.runs.runs import TIME, model, motion, noise, require

MOTORS = """std_msgs/Header header
own_msgs/Motor[2] motor_state
================================================================================
MSG: own_msgs/Motor
float32 q
float32 tau_est
"""


def require_usual(path, **options):
    [recording] = import_source(path, model(), **options)
    require(recording, position=motion(), torque=noise(), atol=1e-8)
    require(recording, time=TIME, atol=1e-6)
    return recording


def test_an_array_of_numpy_has_numbered_or_named_columns(tmp_path):
    np.save(tmp_path / "plain.npy", np.column_stack([TIME, motion(), noise()]))
    columns = {"time": "1", "position": "2..3", "torque": "4..5"}
    require_usual(tmp_path / "plain.npy", columns=columns)
    rows = np.zeros(len(TIME), [("t", "f8"), ("q", "f8", (2,)), ("tau", "f8", (2,))])
    rows["t"], rows["q"], rows["tau"] = TIME, motion(), noise()
    np.save(tmp_path / "named.npy", rows)
    require_usual(tmp_path / "named.npy")


def test_objects_beside_the_samples_are_no_obstacle(tmp_path):
    np.savez(tmp_path / "run.npz", t=TIME, q=motion(), tau=noise(), meta=np.array({"robot": "small"}))
    require_usual(tmp_path / "run.npz")


@pytest.mark.parametrize("form", ["lists", "joints", "joint_state"])
def test_json_lines(tmp_path, form):
    def row(time, q, tau):
        if form == "lists":
            return {"t": time, "state": {"q": q, "tau": tau}, "note": "free"}
        if form == "joints":
            pairs = zip(("axis2", "axis1"), q[::-1], tau[::-1], strict=True)
            return {"time": time, "joints": [{"name": n, "position": p, "effort": e} for n, p, e in pairs]}
        sec, nanosec = divmod(round(1e9 * time), 10**9)
        stamp = {"header": {"stamp": {"sec": sec, "nanosec": nanosec}}}
        return stamp | {"name": ["axis2", "axis1"], "position": q[::-1], "effort": tau[::-1]}

    samples = zip(TIME.tolist(), motion().tolist(), noise().tolist(), strict=True)
    lines = [json.dumps(row(*sample)) for sample in samples]
    (tmp_path / "run.jsonl").write_text("\n".join([*lines, lines[0][:-5]]))
    require_usual(tmp_path / "run.jsonl")
    (tmp_path / "run.jsonl").write_text("\n".join([lines[0], "[1]", *lines]))
    with pytest.raises(NotAFile, match="line 2: not a JSON object"):
        read_tables(tmp_path / "run.jsonl")


@pytest.mark.parametrize("order", ["samples", "blocks"])
@pytest.mark.parametrize(
    ("column", "joints"), [("motor_id", ("11", "12")), ("joint", ("axis1", "axis2")), ("Joint Name", "ab")]
)
def test_a_row_per_joint(tmp_path, order, column, joints):
    cells = np.stack([np.column_stack([TIME, np.degrees(motion())[:, k], noise()[:, k]]) for k in (0, 1)])
    rows = [(joint, *cells[k, t]) for t in range(len(TIME)) for k, joint in enumerate(joints)]
    rows = rows if order == "samples" else sorted(rows, key=lambda row: row[0])
    lines = [f"{time},{joint},{q},{tau}" for joint, time, q, tau in rows]
    (tmp_path / "run.csv").write_text("\n".join([f"time,{column},pos [deg],tau", *lines]))
    named = {"joints": ["a", "b"]} if joints == "ab" else {}
    require_usual(tmp_path / "run.csv", **named)


def test_a_column_of_a_state_does_not_make_rows_of_joints(tmp_path):
    axis = np.repeat([0, 1], len(TIME) // 2)
    rows = np.column_stack([TIME, axis, motion(), noise()])
    np.savetxt(tmp_path / "run.csv", rows, "%.9f", ",", header="t,axis id,q1,q2,tau1,tau2", comments="")
    require_usual(tmp_path / "run.csv")


def own_message(encoding="cdr"):
    """Schema of an own message and the function that turns a message into bytes."""
    typesys = pytest.importorskip("rosbags.typesys")
    store, kind = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE), "own_msgs/msg/LowState"
    store.register(typesys.get_types_from_msg(MOTORS, kind))

    def data(message):
        time = store.types["builtin_interfaces/msg/Time"](*divmod(message.stamp, 10**9))
        motor = store.types["own_msgs/msg/Motor"]
        motors = [motor(*pair) for pair in zip(message.position, message.effort, strict=True)]
        state = store.types[kind](store.types["std_msgs/msg/Header"](time, ""), motors)
        return bytes(store.serialize_cdr(state, kind))

    text, _ = store.generate_msgdef(kind, ros_version=2)
    return kind, "ros2msg", text.encode(), data


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("stamped", [True, False])
def test_fields_of_own_messages_are_columns(tmp_path, stamped):
    messages = sent(("axis1", "axis2"), topic="/lowstate", stamped=stamped)
    path = bags.write_mcap(tmp_path / "run.mcap", messages, "cdr", own_message())
    [recording] = import_source(path, model())
    assert set(recording.signals) == {"position", "torque"}
    assert len(recording.signals["position"]) == 300
    require(recording, torque=[message.effort for message in messages], atol=1e-6)
    [degrees] = import_source(path, model(), degrees=True, columns={"torque": "motor_state.tau_est"})
    np.testing.assert_allclose(
        np.degrees(degrees.signals["position"].values), recording.signals["position"].values, atol=1e-6
    )


@pytest.mark.usefixtures("in_process")
def test_of_two_topics_with_the_joints_one_is_chosen(tmp_path):
    both = [message for topic in ("/a", "/b") for message in sent(("axis1", "axis2"), topic=topic)]
    path = bags.write_mcap(tmp_path / "run.mcap", both, "cdr", own_message())
    with pytest.raises(Exception, match="/a, /b have the robot's joints; choose one by --topic"):
        import_source(path, model())
    assert len(import_source(path, model(), topic="/b")) == 1


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_folder_of_a_bag_without_metadata(tmp_path, kind):
    messages = sent(("axis1", "axis2"))
    if kind == "db3":
        folder = bags.write_ros2(tmp_path / "bag", messages)
        (folder / "metadata.yaml").unlink()
    else:
        folder = tmp_path / "bag"
        folder.mkdir()
        bags.write_mcap(folder / "run_0.mcap", messages, "cdr", bags.as_ros("cdr"))
    [recording] = import_source(folder, model())
    assert len(recording.signals["position"]) == 300
