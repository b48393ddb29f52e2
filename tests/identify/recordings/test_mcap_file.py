"""Files: exact, and read by others; events and timing of a run survive writing and reading."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from mcap.reader import make_reader

from exidyn.identification.arm.newton_euler import link_frames, link_poses
from exidyn.identification.errors import WrongShape
from exidyn.identification.recordings.mcap import cdr
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.mcap.mcap_topics import nanoseconds
from exidyn.identification.recordings.recording import Event, Signal, Timing

from ...parts.runs.full_run import recording
from ...parts.runs.runs import require


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    write_recording(recording(), path)
    return path


@pytest.mark.parametrize("host", [True, False])
def test_what_is_read_is_what_was_written(tmp_path, host):
    written = replace(recording(host), warnings=("suspicious",))
    write_recording(written, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert set(read.signals) == set(written.signals)
    for name, signal in written.signals.items():
        assert np.array_equal(read.signals[name].time, signal.time), name
        assert np.array_equal(read.signals[name].values, signal.values, equal_nan=True), name
    for name in ("name", "payload", "trajectory", "settings", "warnings"):
        assert getattr(read, name) == getattr(written, name)
    assert np.array_equal(read.host_time, written.host_time) if host else read.host_time is None
    assert read.model.names == written.model.names
    assert read.robot.joints == written.robot.joints
    assert not list(tmp_path.glob("*.part"))


def test_negative_controller_time_survives(tmp_path):
    before = recording(host=False)
    early = {name: Signal(signal.time - 2.0000005, signal.values) for name, signal in before.signals.items()}
    write_recording(replace(before, signals=early), tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    require(read, time=early["position"].time)


def test_the_explanation_stands_before_the_samples(file):
    with open(file, "rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        first = min(chunk.chunk_start_offset for chunk in summary.chunk_indexes)
        assert [index.name for index in summary.metadata_indexes] == ["exidyn", "settings"]
        attached = [index.name for index in summary.attachment_indexes]
        assert attached == ["robot.toml", "robot.urdf", "trajectory"]
        assert all(index.offset < first for index in (*summary.metadata_indexes, *summary.attachment_indexes))
        topics = {channel.topic: channel for channel in summary.channels.values()}
        assert topics["/motor_current"].metadata["unit"] == "A"
        assert topics["/motor_current"].metadata["names"] == "achse_1,achse_2,achse_3"
        assert {index.compression for index in summary.chunk_indexes} == {"lz4"}


def test_messages_are_in_the_order_of_the_host_clock(file):
    with open(file, "rb") as stream:
        times = [
            message.log_time for _, _, message in make_reader(stream).iter_messages(log_time_order=False)
        ]
    assert times == sorted(times)


def test_rosbags_reads_every_number(file):
    highlevel = pytest.importorskip("rosbags.highlevel")
    written = recording()
    found: dict[str, list] = {}
    with highlevel.AnyReader([file]) as reader:
        for connection, stamp, raw in reader.messages():
            found.setdefault(connection.topic, []).append(
                (stamp, reader.deserialize(raw, connection.msgtype))
            )
    states = [message for _, message in found["/joint_states"]]
    assert states[0].name == ["achse_1", "achse_2", "achse_3"]
    assert np.array_equal([m.position for m in states], written.signals["position"].values)
    assert np.array_equal([m.velocity for m in states], written.signals["velocity"].values)
    assert all(len(m.effort) == 0 for m in states)
    assert [stamp for stamp, _ in found["/joint_states"]] == written.host_time.tolist()
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in states]
    assert stamps == nanoseconds(written.signals["position"].time).tolist()
    for topic, signal in (("/motor_current", "current"), ("/joint_torque", "torque")):
        assert np.array_equal([m.data for _, m in found[topic]], written.signals[signal].values)
    command = [m.position for _, m in found["/joint_command"]]
    assert np.array_equal(command, written.signals["command"].values)
    assert found["/robot_description"][0][1].data.startswith("<?xml")


def test_rerun_reads_every_number(file):
    chunk = pytest.importorskip("rerun.chunk")
    batches = [
        chunk.to_record_batch()
        for chunk in chunk.McapReader(file, include_topic_regex=["^/joint_states$"]).stream()
        if chunk.entity_path == "/joint_states/position" and not chunk.is_static
    ]
    positions = np.concatenate([b["Scalars:scalars"].flatten().to_numpy().reshape(-1, 3) for b in batches])
    assert np.array_equal(positions, recording().signals["position"].values)


def test_transforms_put_links_where_forward_kinematics_does(file):
    highlevel = pytest.importorskip("rosbags.highlevel")
    written = recording()
    with highlevel.AnyReader([file]) as reader:
        chosen = [connection for connection in reader.connections if connection.topic == "/tf"]
        messages = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections=chosen)]
    # 50 a second of 5 s, and one more where the clock's jitter begins a new fiftieth.
    assert 249 <= len(messages) <= 251
    stamps = [m.transforms[0].header.stamp for m in messages]
    times = np.array([stamp.sec + stamp.nanosec * 1e-9 for stamp in stamps])
    shown = messages[100]
    row = np.argmin(np.abs(written.signals["position"].time - times[100]))
    kinematics = written.robot.kinematics
    data = kinematics.createData()
    pin.forwardKinematics(kinematics, data, written.signals["position"].values[row])
    placement = pin.SE3.Identity()
    for joint, transform in enumerate(shown.transforms):
        at, turn = transform.transform.translation, transform.transform.rotation
        pose = np.array([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
        placement = placement * pin.XYZQUATToSE3(pose)
        np.testing.assert_allclose(placement.homogeneous, data.oMi[joint + 1].homogeneous, atol=1e-12)
    named = [(transform.header.frame_id, transform.child_frame_id) for transform in shown.transforms]
    assert named == [(frame.parent, frame.child) for frame in link_frames(kinematics)]


def test_link_names_are_those_of_the_urdf():
    urdf = """<robot name="two"><link name="floor"/><link name="plate"/><link name="arm"/><link name="hand"/>
      <joint name="bolt" type="fixed"><parent link="floor"/><child link="plate"/><origin xyz="0 0 1"/></joint>
      <joint name="a" type="revolute"><parent link="plate"/><child link="arm"/><origin xyz="0.5 0 0"/>
        <axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
      <joint name="weld" type="fixed"><parent link="arm"/><child link="hand"/></joint></robot>"""
    kinematics = pin.buildModelFromXML(urdf)
    [frame] = link_frames(kinematics)
    assert (frame.parent, frame.child) == ("plate", "arm")
    np.testing.assert_allclose(link_poses(kinematics, np.zeros((1, 1)))[0, 0], [0.5, 0, 0, 0, 0, 0, 1])


TIME = np.arange(100) * 0.002


def timing():
    random = np.random.default_rng(0)
    stage = np.repeat([0, 2, 3, 4], 25)
    return Timing(TIME, random.normal(size=100), random.integers(0, 9, 100), stage, ("listening", "running"))


def test_events_timing_and_outcome_are_read_as_they_were_written(tmp_path):
    events = (
        Event(-0.5, "driver", "it began", {}),
        Event(0.25, "stop", 'joint2: "ü" is 3 away', {"joint": "joint2", "value": 3.0, "limit": [1, 2]}),
    )
    written = replace(recording(), events=events, timing=timing(), outcome={"stop": "tracking"})
    write_recording(written, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert read.events == events
    assert read.outcome == {"stop": "tracking"}
    assert read.timing.stages == timing().stages
    for name in ("time", "lateness", "skipped", "stage"):
        assert np.array_equal(getattr(read.timing, name), getattr(timing(), name))


def test_a_recording_without_events_has_none_and_timing_has_one_value_a_cycle(tmp_path):
    write_recording(recording(), tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert (read.events, read.timing, dict(read.outcome)) == ((), None, {})
    with pytest.raises(WrongShape, match=r"skipped has shape \(99,\)"):
        Timing(TIME, np.zeros(100), np.zeros(99), np.zeros(100))


@pytest.mark.parametrize("cut", [4, 25, 53])
def test_a_damaged_event_raises_nothing_but_value_errors(cut):
    whole = cdr.log_message(1_500_000_000, cdr.WARN, "name", "text", "{}")
    assert cdr.read_log(whole) == cdr.LogMessage(1_500_000_000, cdr.WARN, "name", "text", "{}")
    with pytest.raises(ValueError, match=r".+"):
        cdr.read_log(whole[: min(cut, len(whole) - 5)])
