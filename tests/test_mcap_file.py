"""Files: exact, read by others, and read as far as they go."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from exidyn.identify.effects import CoulombFriction, RigidBody
from exidyn.identify.errors import NotAFile, RecordingError
from exidyn.identify.link_frames import link_frames, link_poses
from exidyn.identify.mcap_file import read_recording, write_recording
from exidyn.identify.mcap_topics import nanoseconds
from exidyn.identify.model import Model
from exidyn.identify.recording import KnownPayload, Recording, Signal
from exidyn.identify.robot import Limits, Robot
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

SAMPLES = 2500


def model() -> Model:
    """Three joints that turn, the middle one behind a bend, and one that slides."""
    kinematics = pin.Model()
    bend = pin.SE3(pin.rpy.rpyToMatrix(0.3, -1.2, 0.5), np.array([0.1, 0.0, 0.4]))
    for place in range(3):
        joint = pin.JointModelPZ() if place == 2 else pin.JointModelRZ()
        index = kinematics.addJoint(place, joint, bend, f"achse_{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    far = np.full(3, np.inf)
    robot = Robot("small", kinematics, Limits(np.full(3, -4.0), np.full(3, 4.0), far, far, far, far))
    return Model(robot, (RigidBody(), CoulombFriction(("achse_1",))))


def recording(host: bool = True) -> Recording:
    """A run whose signals all have their own rate and bits in every place of the mantissa."""
    random = np.random.default_rng(0)
    time = np.arange(SAMPLES) * 0.002 + random.uniform(0, 1e-4, SAMPLES)
    position = 0.5 * np.sin(np.outer(time, [3.0, 4.0, 5.0]))
    temperature = 40.0 + random.normal(size=(SAMPLES // 100, 3))
    temperature[:, 1] = np.nan
    signals = {
        "position": Signal(time, position),
        "velocity": Signal(time, np.gradient(position, time, axis=0)),
        "current": Signal(time + 1e-4, random.normal(size=position.shape)),
        "torque": Signal(time[::2], random.normal(size=position[::2].shape)),
        "temperature": Signal(time[50::100], temperature),
        "link_position": Signal(time[::4], position[::4] + 1e-4),
        "command": Signal(time - 0.004, position),
    }
    clock = 1_800_000_000_000_000_000 + nanoseconds(time) + random.integers(0, 300_000, SAMPLES)
    return Recording(
        name="a run with an ü",
        model=model(),
        signals=signals,
        payload=KnownPayload("weight", (("M", 175.0), ("MX", 1 / 3))),
        trajectory="[trajectory]\n",
        settings={"role": "identify", "units": "rad, A"},
        host_time=clock if host else None,
    )


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    write_recording(recording(), path)
    return path


@pytest.mark.parametrize("host", [True, False])
def test_what_is_read_is_what_was_written(tmp_path, host):
    written = replace(recording(host), warnings=("doubtful",))
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
    assert np.array_equal(read.signals["position"].time, early["position"].time)


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


def test_a_file_cut_anywhere_is_read_up_to_the_cut(file, tmp_path):
    whole, data = recording(), file.read_bytes()
    cuts = np.random.default_rng(1).integers(9, len(data) - 1, 20)
    read = 0
    for cut in np.sort(cuts):
        path = tmp_path / "cut.mcap"
        path.write_bytes(data[:cut])
        try:
            found = read_recording(path)
        except NotAFile as error:
            assert "has no robot inside" in str(error)  # noqa: PT017
            assert read == 0
            continue
        for name, signal in whole.signals.items():
            known = len(found.signals[name])
            assert np.array_equal(found.signals[name].values, signal.values[:known], equal_nan=True)
            assert np.array_equal(found.signals[name].time, signal.time[:known])
            lost = f"{name}: {known} of {len(signal)} samples were read"
            assert known == len(signal) or any(lost in doubt for doubt in found.warnings)
        assert len(found.signals["position"]) >= read
        read = len(found.signals["position"])
        assert found.warnings[0].startswith("file ends abruptly")
    assert read > 0.5 * SAMPLES


def test_a_cut_costs_no_more_than_a_block_of_compression(file, tmp_path):
    data = file.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    found = read_recording(tmp_path / "cut.mcap").signals["position"]
    # Half of the bytes, less a block of 64 KiB, which is about 250 samples with all their signals.
    assert len(found) > 0.4 * SAMPLES


def test_a_cut_before_the_first_sample_still_tells_which_robot(file, tmp_path):
    with open(file, "rb") as stream:
        first = min(chunk.chunk_start_offset for chunk in make_reader(stream).get_summary().chunk_indexes)
    (tmp_path / "cut.mcap").write_bytes(file.read_bytes()[:first])
    found = read_recording(tmp_path / "cut.mcap")
    assert found.robot.joints == ("achse_1", "achse_2", "achse_3")
    assert len(found.signals["position"]) == 0
    assert "there is not one sample in it" in found.warnings[0]


def test_a_damaged_chunk_is_left_out_and_the_rest_is_read(file, tmp_path):
    with open(file, "rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    damaged = bytearray(file.read_bytes())
    place = chunks[1].chunk_start_offset + chunks[1].chunk_length // 2
    damaged[place : place + 100] = bytes(100)
    (tmp_path / "bad.mcap").write_bytes(damaged)
    found = read_recording(tmp_path / "bad.mcap")
    assert any("a damaged chunk" in doubt for doubt in found.warnings)
    assert any("gaps" in doubt for doubt in found.warnings)
    whole = recording().signals["position"]
    kept = np.isin(whole.time, found.signals["position"].time)
    assert 0.5 * SAMPLES < kept.sum() < SAMPLES
    assert np.array_equal(found.signals["position"].values, whole.values[kept])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"t,q1,q2\n0,1,2\n", "is not an MCAP file: it begins with b't,q1,q2"),
        (b"\x89MCAP0\r\n", "has no robot inside"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, content, message):
    (tmp_path / "file.mcap").write_bytes(content)
    with pytest.raises(NotAFile, match=message):
        read_recording(tmp_path / "file.mcap")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(NotAFile, match="none.mcap cannot be read"):
        read_recording(tmp_path / "none.mcap")


def test_someone_elses_mcap_is_refused(tmp_path):
    path = tmp_path / "other.mcap"
    with open(path, "wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        writer.finish()
    with pytest.raises(NotAFile, match="not an exidyn recording"):
        read_recording(path)


def test_a_later_format_is_refused(file, tmp_path):
    data = file.read_bytes()
    assert data.count(b"\x06\x00\x00\x00format\x01\x00\x00\x001") == 1
    later = data.replace(b"format\x01\x00\x00\x001", b"format\x01\x00\x00\x009")
    (tmp_path / "later.mcap").write_bytes(later)
    with pytest.raises(RecordingError, match="has format 9; this version reads 1"):
        read_recording(tmp_path / "later.mcap")


def test_random_damage_raises_nothing_but_our_errors(file, tmp_path):
    data, random = file.read_bytes(), np.random.default_rng(2)
    outcomes = {"read": 0, "refused": 0}
    for _ in range(20):
        damaged = bytearray(data)
        for place in random.integers(8, len(data), 5):
            damaged[place] ^= 0xFF
        (tmp_path / "bad.mcap").write_bytes(damaged)
        try:
            read_recording(tmp_path / "bad.mcap")
            outcomes["read"] += 1
        except (RecordingError, ValueError) as error:
            assert type(error).__module__.startswith("exidyn")  # noqa: PT017
            outcomes["refused"] += 1
    assert outcomes["read"] + outcomes["refused"] == 20
    assert outcomes["read"] > 0
