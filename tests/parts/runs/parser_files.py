"""A valid file of every kind that exidyn reads, of one small arm of two joints, as a folder on the disk."""

import json
import struct
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib import resources
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

import h5py
import numpy as np
import scipy.io
from mcap.writer import CompressionType, Writer

from exidyn.acquire.files.result_files import write_diagnosis
from exidyn.drivers.ur_rtde.rtde import DATA, OUTPUTS, Recipe, package
from exidyn.drivers.ur_rtde.session import FIELDS, MEASURED
from exidyn.identification.fit.fit_file import fit_text
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.mcap.mcap_records import Contents, read_contents
from exidyn.identification.recordings.recording import Event, Recording, Signal, Timing
from exidyn.identification.robot_files.robot_file import builtin_names, model_text
from exidyn.trajectories.plans.plan_file import plan_text

from ..plans import plans
from ..small import small_diagnosis, small_fit
from ..small.two_joint_files import run

Files = Mapping[str, bytes]
"""Name below the folder -> content."""
EMPTY: Mapping[str, Any] = MappingProxyType({})

URDF = """<?xml version="1.0"?>
<robot name="small">
  <link name="base"/>
  <link name="arm">
    <inertial><origin xyz="0.2 0.01 0.03" rpy="0 0 0"/><mass value="5.0"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>
    <visual><geometry><box size="0.1 0.1 0.4"/></geometry></visual>
  </link>
  <link name="tool0">
    <inertial><mass value="4.6"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 0.3" rpy="0 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" velocity="3.0" effort="200"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="arm"/><child link="tool0"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" velocity="3.0" effort="200"/>
  </joint>
</robot>
"""
CONTROLLERS = {
    "mock": """cycle = 0.004
""",
    "can_mit": """channel = "can0"
model = ["DM4340", "DM4310"]
ids = [1, 2]
masters = [17, 18]
kp = 100
kd = [4, 3.5]
""",
    "canopen_402": """channel = "can0"
nodes = [1, 2]
counts = 65536
gear = [101, 51.0]
sign = [1, -1]
zero = [0.0, -1.5708]
ampere = "rms"
at_close = "off"
""",
    "dynamixel": """port = "/dev/ttyUSB0"
ids = [11, 12]
baudrate = 4_000_000
operating_mode = "extended"
sign = [1, -1]
zero = [2048, 2048]
""",
    "feetech": """port = "/dev/ttyUSB0"
ids = [1, 2]
cycle = 0.003
""",
}
"""Driver -> settings that suffice for two joints."""
SAMPLES = 100


@cache
def short_run() -> Recording:
    """One second with every kind of signal, an event, the timing of the loop, and a planned motion."""
    made = run("run")
    signals = {name: signal[:SAMPLES] for name, signal in made.signals.items()}
    time, count = signals["position"].time, SAMPLES
    warm = Signal(time[::50], 40.0 + np.outer(time[::50], [1.0, 2.0]))
    return replace(
        made,
        signals={**signals, "temperature": warm, "command": signals["position"]},
        trajectory=plan(),
        settings={"role": "identify", "driver": "mock"},
        host_time=1_700_000_000_000_000_000 + np.arange(count) * 4_000_000,
        events=(Event(0.5, "note", "half way", {"joint": "elbow"}),),
        timing=Timing(time, np.full(count, 1e-4), np.zeros(count), np.zeros(count), ("move",)),
        outcome={"stop": "none", "text": "the motion came to its end"},
    )


@cache
def plan() -> str:
    """A trajectory file."""
    return plan_text(plans.known_plan(plans.sequence()))


@cache
def table() -> bytes:
    """A run as CSV."""
    signals = short_run().signals
    columns = signals["position"].time, signals["position"].values, signals["current"].values
    rows = [",".join(f"{value:.6g}" for value in row) for row in np.column_stack(columns)]
    return "\n".join(["t,q1,q2,i1,i2", *rows, ""]).encode()


PRESET: Mapping[str, Any] = {
    "time": {"column": "t", "unit": "s"},
    "position": {"column": ["q1", "q2"], "unit": "rad", "sign": [1, -1]},
    "current": {"column": "i{number}", "unit": "A", "sign": 1},
}


def toml_of(table: bytes) -> bytes:
    """JSON of at most one table in a table, as TOML."""
    try:
        content = json.loads(table)
    except ValueError:
        return table
    plain = content if isinstance(content, dict) else {"value": content}
    lines = [f"{key} = {json.dumps(value)}" for key, value in plain.items() if not isinstance(value, dict)]
    for name, value in plain.items():
        if isinstance(value, dict):
            lines += [f"[{name}]", *(f"{key} = {json.dumps(one)}" for key, one in value.items())]
    return "\n".join(lines).replace("NaN", "nan").replace("Infinity", "inf").encode()


@cache
def matlab() -> bytes:
    """A run as MATLAB's version 5, which is not compressed."""
    made = BytesIO()
    scipy.io.savemat(made, _arrays() | {"note": "free", "log": {"t": np.arange(3.0), "name": "a"}})
    return made.getvalue()


@cache
def hdf5() -> bytes:
    """A run as HDF5, with a group, chunks and an attribute."""
    made = BytesIO()
    with h5py.File(made, "w") as file:
        for name, values in _arrays().items():
            file.create_dataset(name, data=values, chunks=values.shape)
        file["arm/temperature"] = np.full(SAMPLES, 30.0)
        file.attrs["robot"] = "small"
    return made.getvalue()


def _arrays() -> dict[str, np.ndarray]:
    signals = short_run().signals
    position = signals["position"]
    return {"t": position.time, "q": position.values, "i": signals["current"].values}


RTDE_TYPES = (
    "DOUBLE,VECTOR6D,VECTOR6D,VECTOR6D,VECTOR6D,VECTOR6D,VECTOR6INT32,INT32,INT32,UINT32,DOUBLE,DOUBLE"
)


@cache
def rtde_packages() -> bytes:
    """The answer to a recipe, and ten packages of an arm that moves."""
    names, answer = [*MEASURED, *FIELDS], b"\x01" + RTDE_TYPES.encode()
    recipe, packages = Recipe(names, answer), [package(OUTPUTS, answer)]
    for place in range(10):
        values = {"timestamp": 100.0 + 0.002 * place, "actual_q": np.full(6, 0.1 * place), "robot_mode": 7,
                  "safety_mode": 1, "runtime_state": 2, "target_speed_fraction": 1.0,
                  "speed_scaling": 1.0}  # fmt: skip
        packages.append(package(DATA, recipe.written(values)))
    return b"".join(packages)


def robots() -> dict[str, Files]:
    """Robot files: spelled out, by modified DH, by a URDF beside them."""
    robots = resources.files("exidyn.identification.robot_files").joinpath("robots")
    built_in = {f"{name}.toml": robots.joinpath(f"{name}.toml").read_bytes() for name in builtin_names()}
    spelled = model_text(small_fit.fit().model).encode()
    beside = (
        b'format = 1\nname = "small"\nurdf = "robot.urdf"\n[limits]\nvelocity = [3.0, 2.0]\njerk = 200.0\n'
    )
    return {name: {name: text} for name, text in built_in.items()} | {
        "robot.toml": {"robot.toml": spelled},
        "urdf.toml": {"urdf.toml": beside, "robot.urdf": URDF.encode()},
    }


def write_two_traces(folder: Path) -> None:
    """Write two KUKA traces, which are two runs, into a folder."""
    files = trace()
    again = {name.replace("run", "again"): data.replace(b"run_", b"again_") for name, data in files.items()}
    write(files | again, folder)


def write(files: Files, folder: Path) -> None:
    """Write files into a folder."""
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def with_positions(values: bytes) -> bytes:
    """The recording with these positions, two doubles a sample."""
    made = short_run()
    positions = Signal(made.signals["position"].time, np.frombuffer(values).reshape(SAMPLES, 2))
    return written(replace(made, signals={**made.signals, "position": positions}))


@cache
def recording_bytes() -> bytes:
    """A recording."""
    return written(short_run())


def written(recording: Recording) -> bytes:
    """A recording as the bytes of its file."""
    with TemporaryDirectory() as folder:
        write_recording(recording, Path(folder) / "run.mcap")
        return (Path(folder) / "run.mcap").read_bytes()


@cache
def explanation() -> Contents:
    """What explains the recording, and its messages."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        path.write_bytes(recording_bytes())
        return read_contents(path)


def rewritten(metadata: Mapping[str, Mapping[str, str]] = EMPTY, attachments: Files = EMPTY) -> bytes:
    """The recording, with some of what explains it replaced.

    Without compression and checksums, so that damage reaches the parser.
    """
    contents, file = explanation(), BytesIO()
    writer = Writer(file, compression=CompressionType.NONE, enable_crcs=False)
    writer.start(profile="ros2", library="exidyn")
    for name, record in (contents.metadata | dict(metadata)).items():
        writer.add_metadata(name, dict(record))
    for one in contents.attachments.values():
        data = attachments.get(one.name, one.data)
        writer.add_attachment(one.create_time, one.log_time, one.name, one.media_type, data)
    schemas = {0: 0} | {
        number: writer.register_schema(schema.name, schema.encoding, schema.data)
        for number, schema in contents.schemas.items()
    }
    channels = {
        number: writer.register_channel(
            channel.topic, channel.message_encoding, schemas[channel.schema_id], channel.metadata
        )
        for number, channel in contents.channels.items()
    }
    for message in contents.messages_in_order():
        number = channels[message.channel_id]
        writer.add_message(number, message.log_time, message.data, message.publish_time)
    writer.finish()
    return file.getvalue()


def trace() -> Files:
    """A KUKA trace of two drives."""
    signals = short_run().signals
    files: dict[str, bytes] = {}
    for axis in range(2):
        channels = {
            "Istposition,°": np.degrees(signals["position"].values[:, axis]),
            "Iststrom,A": signals["current"].values[:, axis],
        }
        rows = ["DIAEXTENDED  {@:ENGLISH", "#BEGINCHANNELHEADER", "200,Zeit", "202,s", "210,IMPLIZIT"]
        rows += [f"220,{SAMPLES}", "240,0", "241,0.004", "#ENDCHANNELHEADER"]
        for place, name in enumerate(channels):
            title, unit = name.split(",")
            rows += ["#BEGINCHANNELHEADER", f"200,{title}", f"202,{unit}", "210,EXPLIZIT"]
            rows += [f"211,run_NextGenDrive#{axis + 1}.r64", "213,BLOCK", "214,REAL64", f"220,{SAMPLES}"]
            rows += [f"221,{place + 1}", "240,0.0", "241,1.0", "#ENDCHANNELHEADER"]
        stem = f"run_NextGenDrive#{axis + 1}"
        files[f"{stem}.dat"] = "\r\n".join(rows).encode("iso-8859-1")
        values = np.column_stack(list(channels.values())).ravel()
        files[f"{stem}.r64"] = struct.pack(f"<{len(values)}d", *values)
    return files


@cache
def fit_bytes() -> bytes:
    """A fit."""
    return fit_text(small_fit.fit()).encode()


@cache
def currents_fit_bytes() -> bytes:
    """A fit of one run without payload, whose gains nothing shows."""
    return fit_text(small_fit.plain_fit()).encode()


@cache
def diagnosis_files() -> Files:
    """A diagnosis and its samples."""
    with TemporaryDirectory() as name:
        write_diagnosis(small_diagnosis.diagnosis(), None, Path(name))
        return {one: (Path(name) / one).read_bytes() for one in ("diagnosis.json", "traces.npz")}
