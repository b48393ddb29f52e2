"""Files that were cut off or damaged are read as far as they go."""

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from exidyn.identification.errors import NotAFile, RecordingError
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.mcap.mcap_topics import nanoseconds, topics_of
from exidyn.identification.recordings.mcap.mcap_writer import EPOCH, Head, RecordingWriter

from ...parts.runs.full_run import SAMPLES, model, recording
from ...parts.runs.runs import require


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    write_recording(recording(), path)
    return path


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
            assert "contains no robot" in str(error)  # noqa: PT017
            assert read == 0
            continue
        for name, signal in whole.signals.items():
            known = len(found.signals[name])
            assert np.array_equal(found.signals[name].values, signal.values[:known], equal_nan=True)
            assert np.array_equal(found.signals[name].time, signal.time[:known])
            lost = f"{name}: {known} of {len(signal)} samples were read"
            assert known == len(signal) or any(lost in warning for warning in found.warnings)
        assert len(found.signals["position"]) >= read
        read = len(found.signals["position"])
        assert found.warnings[0].startswith("file ends abruptly")
    assert read > 0.5 * SAMPLES


def test_a_cut_before_the_first_sample_still_names_the_robot(file, tmp_path):
    with open(file, "rb") as stream:
        first = min(chunk.chunk_start_offset for chunk in make_reader(stream).get_summary().chunk_indexes)
    (tmp_path / "cut.mcap").write_bytes(file.read_bytes()[:first])
    found = read_recording(tmp_path / "cut.mcap")
    assert found.robot.joints == ("achse_1", "achse_2", "achse_3")
    assert len(found.signals["position"]) == 0
    assert "it has no samples" in found.warnings[0]


def test_a_damaged_chunk_is_left_out_and_the_rest_is_read(file, tmp_path):
    with open(file, "rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    damaged = bytearray(file.read_bytes())
    place = chunks[1].chunk_start_offset + chunks[1].chunk_length // 2
    damaged[place : place + 100] = bytes(100)
    (tmp_path / "bad.mcap").write_bytes(damaged)
    found = read_recording(tmp_path / "bad.mcap")
    assert any("a damaged chunk" in warning for warning in found.warnings)
    assert any(" gap of" in warning or " gaps of" in warning for warning in found.warnings)
    whole = recording().signals["position"]
    kept = np.isin(whole.time, found.signals["position"].time)
    assert 0.5 * SAMPLES < kept.sum() < SAMPLES
    require(found, position=whole.values[kept])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"t,q1,q2\n0,1,2\n", "is not an MCAP file: it begins with b't,q1,q2"),
        (b"\x89MCAP0\r\n", "contains no robot"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, content, message):
    (tmp_path / "file.mcap").write_bytes(content)
    with pytest.raises(NotAFile, match=message):
        read_recording(tmp_path / "file.mcap")


def test_someone_elses_mcap_is_refused(tmp_path):
    path = tmp_path / "other.mcap"
    with open(path, "wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE)
        writer.start()
        writer.finish()
    with pytest.raises(NotAFile, match="not an exidyn recording"):
        read_recording(path)


@pytest.mark.parametrize(
    ("whole", "changed", "error", "message"),
    [
        (b"format\x01\x00\x00\x001", b"format\x01\x00\x00\x009", RecordingError, "has format 9; .* reads 1"),
        (b"\x03\x00\x00\x00lz4", b"\x03\x00\x00\x00lz5", NotAFile, "compressed by 'lz5'; valid are lz4"),
        (b'{"name": "weight"', b'{"nome": "weight"', NotAFile, "its description is damaged: 'name'"),
    ],
    ids=["a later format", "another compression", "a damaged explanation"],
)
def test_what_cannot_be_read_is_named(file, tmp_path, whole, changed, error, message):
    data = file.read_bytes()
    assert whole in data
    (tmp_path / "other.mcap").write_bytes(data.replace(whole, changed))
    with pytest.raises(error, match=message):
        read_recording(tmp_path / "other.mcap")


def test_a_recorder_that_never_finished_is_read(tmp_path):
    """As acquisition writes it: the number of samples is unknown, and then the power fails."""
    joints = model().robot.joints
    signals = {name: recording().signals[name] for name in ("position", "torque")}
    path = tmp_path / "run.mcap"
    with open(path, "wb") as stream:
        writer = RecordingWriter(stream, Head("run", model(), host_clock=True))
        for topic in topics_of(signals):
            time = nanoseconds(signals[next(iter(topic.fields))].time) + EPOCH
            for message, moment in zip(topic.messages(joints, signals), time.tolist(), strict=True):
                writer.write(topic, message.tobytes(), moment, moment + 5)
    found = read_recording(path)
    assert set(found.signals) == {"position", "torque"}
    known = len(found.signals["position"])
    assert 0.5 * SAMPLES < known
    require(found, position=signals["position"].values[:known])
    assert np.array_equal(found.host_time, nanoseconds(found.signals["position"].time) + EPOCH + 5)
    assert found.warnings[0].startswith(f"file ends abruptly: the run is known up to {found.duration:.3f}")
