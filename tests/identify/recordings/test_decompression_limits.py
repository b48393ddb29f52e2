"""Small files that are large once decompressed are refused, before they fill the memory."""

import gzip
import struct
import zlib

import lz4.frame
import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from exidyn.identification.errors import NotAFile, RecordingError
from exidyn.identification.recordings.importers import import_source, read_tables
from exidyn.identification.recordings.mcap.mcap_records import read_contents
from exidyn.identification.recordings.reading_limits import LEAST, RATIO, VARIABLE, largest_size

from ...parts.runs.runs import model

MESSAGE = (
    r"its content exceeds \d+ MB, the limit for its size. If its source is trusted, state a larger limit"
)
NUMBERS = 20_000
"""Numbers in a file of these tests; 8 bytes each exceed the limit that they set."""


@pytest.fixture(autouse=True)
def limit(monkeypatch):
    monkeypatch.setenv(VARIABLE, "100000")


def csv(path):
    with gzip.open(path, "wt") as file:
        file.write("t,q1\n" + "0,0\n" * NUMBERS)


def npz(path):
    np.savez_compressed(path, q=np.zeros((NUMBERS, 2)))


def npz_of_bytes(path):
    np.savez_compressed(path, q=np.zeros(NUMBERS, np.int8))


def matlab(path):
    pytest.importorskip("scipy.io").savemat(path, {"q": np.zeros((NUMBERS, 2))}, do_compression=True)


def hdf5(path):
    with pytest.importorskip("h5py").File(path, "w") as file:
        file.create_dataset("q", data=np.zeros((NUMBERS, 2)), compression="gzip")


def parquet(path):
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("pyarrow.parquet").write_table(pyarrow.table({"q": np.zeros(NUMBERS)}), path)


FILES = {
    "run.csv.gz": csv, "run.npz": npz, "bytes.npz": npz_of_bytes, "run.mat": matlab, "run.h5": hdf5,
    "run.parquet": parquet,
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_what_exceeds_the_limit_is_refused_and_a_larger_limit_can_be_stated(tmp_path, monkeypatch, name):
    path = tmp_path / name
    FILES[name](path)
    assert path.stat().st_size < 20_000
    with pytest.raises(NotAFile, match=MESSAGE) as caught:
        read_tables(path)
    stated = str(caught.value).rpartition("=")[2]
    assert str(caught.value).endswith(f"in bytes: {VARIABLE}={stated}")
    monkeypatch.setenv(VARIABLE, stated)
    [table] = read_tables(path)
    assert len(table.values) == NUMBERS


def recording(path, content):
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=1 << 30, compression=CompressionType.LZ4)
        writer.start()
        channel = writer.register_channel("x", "cdr", writer.register_schema("s", "ros2msg", b""))
        writer.add_message(channel, 0, content, 0)
        writer.finish()


def test_chunks_of_a_recording_are_limited(tmp_path, monkeypatch):
    path = tmp_path / "run.mcap"
    recording(path, bytes(200_000))
    with pytest.raises(NotAFile, match=MESSAGE):
        read_contents(path)
    monkeypatch.setenv(VARIABLE, "300000")
    [chunk] = read_contents(path).chunks
    assert len(chunk) > 200_000


def test_a_chunk_that_states_less_than_it_holds_is_not_unpacked(tmp_path):
    """The limit counts what is unpacked, not what the file states."""
    path = tmp_path / "run.mcap"
    packed = lz4.frame.compress(bytes(10_000_000))
    body = struct.pack("<QQQI", 0, 1, 1000, zlib.crc32(bytes(1000))) + struct.pack("<I", 3) + b"lz4"
    body += struct.pack("<Q", len(packed)) + packed
    path.write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body)
    assert [len(chunk) for chunk in read_contents(path).chunks] == [1000]


@pytest.mark.parametrize("mode", ["message", "file", "storage"])
def test_a_bag_compressed_by_zstd_is_limited(tmp_path, monkeypatch, mode):
    rosbag2, typesys = (pytest.importorskip(f"rosbags.{name}") for name in ("rosbag2", "typesys"))
    monkeypatch.setattr("exidyn.identification.recordings.reading_limits.LIBRARIES", 100_000_000)
    monkeypatch.setenv(VARIABLE, "10000000")
    plugin = rosbag2.StoragePlugin.MCAP if mode == "storage" else rosbag2.StoragePlugin.SQLITE3
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    bag = rosbag2.Writer(tmp_path / "bomb", version=8, storage_plugin=plugin)
    modes = rosbag2.CompressionMode
    bag.set_compression(
        {"message": modes.MESSAGE, "file": modes.FILE, "storage": modes.STORAGE}[mode],
        rosbag2.CompressionFormat.ZSTD,
    )
    kind = "sensor_msgs/msg/JointState"
    with bag:
        states = bag.add_connection("/joint_states", kind, typestore=store)
        bag.write(states, 10**9, bytes(150_000_000))
    assert sum(file.stat().st_size for file in (tmp_path / "bomb").iterdir()) < 1_000_000
    with pytest.raises(NotAFile, match=MESSAGE):
        import_source(tmp_path / "bomb", model())


def test_the_limit_is_that_of_small_files_or_grows_with_the_file(tmp_path, monkeypatch):
    path = tmp_path / "run.csv.gz"
    path.write_bytes(b"")
    monkeypatch.delenv(VARIABLE)
    assert largest_size(path) == LEAST
    with open(path, "wb") as file:
        file.truncate(LEAST)  # which takes no place on the disk
    assert largest_size(path) == largest_size(tmp_path) == RATIO * LEAST
    monkeypatch.setenv(VARIABLE, "many")
    with pytest.raises(RecordingError, match=f"{VARIABLE} is 'many'; expected a number of bytes such as"):
        largest_size(path)
