"""Bombs: small files that would fill the memory or never end, read by the command in a process of its own."""

import gzip
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import scipy.io
from common import show
from mcap.writer import CompressionType, Writer

from tests.parts.runs import parser_files

SIZE, QUICK = 2_000_000_000, 400_000_000
"""Bytes that a bomb holds: ten times the limit for a small file, and twice."""
REFUSED = 2
PATIENCE = 120.0
"""Time after which a command is ended and counts as one that never ends [s]."""
WRAPPER = """
import json, resource, subprocess, sys
run = subprocess.run(sys.argv[2:], capture_output=True, text=True)
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss  # of the command or a child of it
json.dump([run.returncode, run.stderr, 1024e-6 * peak], open(sys.argv[1], "w"))
"""
"""Runs a command and writes its exit code, its standard error, and the most memory of a process [MB]."""
HEADER = ("bomb", "file [kB]", "exit code", "lines", "time [s]", "memory [MB]")


class Outcome(NamedTuple):
    """What a command did with a bomb: exit code, lines of standard error, time [s] and peak memory [MB]."""

    code: int
    lines: int
    seconds: float
    peak: float

    @property
    def well(self) -> bool:
        """Whether it was refused in one line."""
        return self.code == REFUSED and self.lines == 1


def _csv(path: Path, size: int) -> None:
    piece = b"0,0\n" * 250_000
    with gzip.open(path, "wb", compresslevel=1) as file:
        file.write(b"t,q1\n")
        for _ in range(size // len(piece)):
            file.write(piece)


def _npz(path: Path, size: int) -> None:
    np.savez_compressed(path, q=np.zeros((size // 8, 1)))


def _matlab(path: Path, size: int) -> None:
    scipy.io.savemat(path, {"q": np.zeros((size // 8, 1))}, do_compression=True)


def _hdf5(path: Path, size: int) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("q", (size // 8,), float, chunks=(1_000_000,), compression="gzip")


def _parquet(path: Path, size: int) -> None:
    values = pyarrow.array(np.zeros(1_000_000))
    table = pyarrow.table({"t": pyarrow.chunked_array([values] * (size // 8_000_000))})
    pyarrow.parquet.write_table(table, path)


def _mcap(path: Path, size: int) -> None:
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=2 * size, compression=CompressionType.LZ4)
        writer.start()
        channel = writer.register_channel("x", "cdr", writer.register_schema("s", "ros2msg", b""))
        writer.add_message(channel, 0, bytes(size // 2), 0)
        writer.finish()


def _bag(path: Path, size: int) -> None:
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as BagWriter
    from rosbags.typesys import Stores, get_typestore

    bag = BagWriter(path, version=8, storage_plugin=StoragePlugin.SQLITE3)
    bag.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    with bag:
        states = bag.add_connection(
            "/joint_states", "sensor_msgs/msg/JointState", typestore=get_typestore(Stores.ROS2_HUMBLE)
        )
        bag.write(states, 10**9, bytes(size // 2))


XACRO = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">{}<link name="base"/></robot>'
TWICE = """<xacro:macro name="m" params="n"><l/><xacro:if value="${n > 0}"><xacro:m n="${n - 1}"/>
<xacro:m n="${n - 1}"/></xacro:if></xacro:macro><xacro:m n="100"/>"""


def _xacro(content: str) -> Callable[[Path, int], None]:
    return lambda path, size: path.write_text(XACRO.format(content)) and None


def _mjcf(path: Path, size: int) -> None:
    path.write_text('<mujoco><include file="other.xml"/></mujoco>')
    path.with_name("other.xml").write_text(f'<mujoco><include file="{path.name}"/></mujoco>')


BOMBS: dict[str, Callable[[Path, int], None]] = {
    "run.csv.gz": _csv,
    "run.npz": _npz,
    "run.mat": _matlab,
    "run.h5": _hdf5,
    "run.parquet": _parquet,
    "run.mcap": _mcap,
    "bag": _bag,
    "recursion.xacro": _xacro(TWICE),
    "list.xacro": _xacro('<a b="${[0] * 10 ** 10}"/>'),
    "power.xacro": _xacro('<a b="${9 ** 9 ** 9}"/>'),
    "include.xml": _mjcf,
}
"""Name of a file or folder, and what makes it so large."""
SLOW = ("recursion.xacro", "power.xacro")
"""Those that end by the limit of time."""


def main(quick: bool) -> dict[str, object]:
    size = QUICK if quick else SIZE
    found, rows = {}, []
    for name, make in BOMBS.items():
        if quick and name in SLOW:
            continue
        with TemporaryDirectory() as folder:
            path = Path(folder) / name
            make(path, size)
            found[name] = one = _tried(path)
            rows.append((name, 1e-3 * _size(path), *one))
    show(f"Bombs of {1e-6 * size:.0f} MB, each refused in one line (exit code {REFUSED})", HEADER, rows)
    return {
        "bombs": len(found),
        "bombs_refused": sum(one.well for one in found.values()),
        "peak_mb_bombs": max(one.peak for one in found.values()),
    }


def _size(path: Path) -> int:
    files = path.rglob("*") if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files)


def _tried(path: Path) -> Outcome:

    folder = path.parent
    (folder / "robot.urdf").write_text(parser_files.URDF)
    if path.suffix in (".xacro", ".xml"):
        words = ["export", path.name, "--to", "urdf"]
    else:
        words = ["import", path.name, "--robot", "robot.urdf"]
    command = [sys.executable, "-m", "exidyn.acquire.command_line", *words]
    start = perf_counter()
    subprocess.run(
        [sys.executable, "-c", WRAPPER, "out.json", *command],
        cwd=folder,
        timeout=PATIENCE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        check=True,
    )
    code, text, peak = json.loads((folder / "out.json").read_text())
    return Outcome(code, len(text.splitlines()), perf_counter() - start, peak)
