"""Logs to begin from: public recordings, a simulated one, files of other libraries."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model

from .arms import Samples, simulated
from .sets import SETS, Known, RealSet


@dataclass(frozen=True)
class Log:
    """A log."""

    name: str  # In the tables
    # Writes it into a folder; returns the log, the robot's file, and what is true
    make: Callable[[Path], tuple[Path, Path, Known]]


def public() -> list[Log]:
    """One run of each public set."""
    sets = [data for data in SETS if data.path.exists() and not data.drive.startswith("[drive]\ngain")]
    return [Log(f"{data.folder}/{data.runs[0]}", partial(_copied, data)) for data in sets]


def _copied(data: RealSet, folder: Path) -> tuple[Path, Path, Known]:
    return *data.copy(data.runs[0], folder), data.known(data.runs[0])


@cache
def recorded(folder: str) -> Samples:
    """The first run of a data set, in SI."""
    data = next(data for data in SETS if data.folder == folder)
    table, known = data.table(data.runs[0]), data.known(data.runs[0])
    columns = {name: table.values[:, place] for place, name in enumerate(table.names)}
    position, column = (
        np.column_stack([columns[name] for name in known.columns[signal]])
        for signal in ("position", data.effort)
    )
    speeds = [name.replace("q", "dq") for name in known.columns["position"]]
    velocity = np.column_stack([columns[name] for name in speeds]) if known.velocity else None
    arm = data.path / data.robot
    return Samples(
        columns["t"], position, velocity, column, read_model(arm).robot.joints, arm.read_text(), data.gain
    )


Write = Callable[[Samples, Path], tuple[Path, Known]]


def foreign() -> list[Log]:
    """One log a format, from simulated and real runs."""
    ur, panda = partial(recorded, "ur10e_mamedov"), partial(recorded, "panda_gaz")
    tx40, kr300 = partial(recorded, "staubli_tx40"), partial(recorded, "kuka_kr300_weigand")
    table: dict[str, tuple[Callable[[], Samples], Write]] = {
        "scipy.io.savemat, structure": (panda, matlab),
        "h5py, degrees, ms": (simulated, hdf5),
        "h5py as MATLAB 7.3": (ur, matlab73),
        "pandas, degrees, ms": (ur, pandas_csv),
        "semicolons, decimal commas, German": (simulated, german_csv),
        "UR RTDE client": (ur, rtde),
        "rosbags, sorted names, effort in A": (ur, rosbag),
        "rosbags, effort in N m": (tx40, rosbag),
        "pyarrow, lists": (simulated, parquet),
        "numpy.savez, us, sorted joints": (ur, npz),
        "LeRobot 3, degrees": (simulated, lerobot),
        "libfranka": (panda, libfranka),
        "numpy.savetxt, degrees": (tx40, savetxt),
        "columns without meaning": (ur, meaningless),
        "numpy.savetxt, no names": (tx40, nameless),
        "CiA 402, per mille, two drives reversed": (simulated, permille),
        "drive torques, ns": (kr300, drive_torque),
    }
    return [Log(name, partial(_written, *one)) for name, one in table.items()]


def _written(samples: Callable[[], Samples], write: Write, folder: Path) -> tuple[Path, Path, Known]:
    arm = folder / "arm.urdf"
    arm.write_text(samples().robot)
    log, known = write(samples(), folder)
    return log, arm, known


def _known(
    samples: Samples, position: str, effort: str, time: str = "time", units: str = "s rad", velocity: str = ""
) -> Known:
    """What is true, from patterns of names with {k} from 1, {i} from 0 and {j} for the joint's name."""
    kind = "current" if samples.gain is not None else "torque"
    columns = {
        signal: [pattern.format(k=k + 1, i=k, j=joint) for k, joint in enumerate(samples.joints)]
        for signal, pattern in (("position", position), (kind, effort))
    }
    clock, angle = units.split()
    return Known(clock, angle, velocity, kind, samples.gain, {"time": [time], **columns})


def _numbered(pattern: str, values: np.ndarray) -> dict[str, np.ndarray]:
    return {pattern.format(k=k + 1, i=k): column for k, column in enumerate(values.T)}


def matlab(run: Samples, folder: Path) -> tuple[Path, Known]:
    """A structure of matrices, in version 5."""
    from scipy.io import savemat

    arrays = {"t": run.time[:, None], "q": run.position, "dq": run.velocity, "tau": run.effort}
    savemat(folder / "log.mat", {"data": arrays})
    return folder / "log.mat", _known(run, "data.q{k}", "data.tau{k}", "data.t", velocity="rad")


def matlab73(run: Samples, folder: Path) -> tuple[Path, Known]:
    """As MATLAB writes it with -v7.3: HDF5 behind 512 bytes, arrays transposed."""
    import h5py

    with h5py.File(folder / "log.mat", "w", userblock_size=512) as file:
        for name, values in (("t", run.time[:, None]), ("pos", run.position), ("curr", run.effort)):
            file.create_dataset(name, data=values.T).attrs["MATLAB_class"] = np.bytes_("double")
    with open(folder / "log.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return folder / "log.mat", _known(run, "pos{k}", "curr{k}", "t")


def hdf5(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Groups, degrees and milliseconds."""
    import h5py

    with h5py.File(folder / "log.h5", "w") as file:
        file["time"] = 1e3 * run.time
        file["arm/position"], file["arm/velocity"] = np.degrees(run.position), np.degrees(run.velocity)
        file["arm/current"] = run.effort
    return folder / "log.h5", _known(run, "arm/position{k}", "arm/current{k}", units="ms deg", velocity="deg")


def pandas_csv(run: Samples, folder: Path) -> tuple[Path, Known]:
    """A table with an index in front, degrees and milliseconds, none of which it says."""
    import pandas

    columns = {"timestamp": 1e3 * run.time, **_numbered("joint{k}_pos", np.degrees(run.position))}
    columns |= _numbered("joint{k}_vel", np.degrees(run.velocity)) | _numbered("joint{k}_current", run.effort)
    pandas.DataFrame(columns).to_csv(folder / "log.csv")
    return folder / "log.csv", _known(
        run, "joint{k}_pos", "joint{k}_current", "timestamp", "ms deg", velocity="deg"
    )


def german_csv(run: Samples, folder: Path) -> tuple[Path, Known]:
    """As Excel writes it in Germany."""
    import pandas

    columns = {"Zeit": run.time, **_numbered("A{k}_Winkel_ist", np.degrees(run.position))}
    table = pandas.DataFrame(columns | _numbered("A{k}_Strom", run.effort))
    table.to_csv(folder / "log.csv", sep=";", decimal=",", index=False)
    return folder / "log.csv", _known(run, "A{k}_Winkel_ist", "A{k}_Strom", "Zeit", "s deg")


def rtde(run: Samples, folder: Path) -> tuple[Path, Known]:
    """What record.py of UR's RTDE client writes, with columns that nobody needs."""
    columns = {"timestamp": 5000.0 + run.time, **_numbered("target_q_{i}", run.position)}
    columns |= _numbered("actual_q_{i}", run.position) | _numbered("actual_qd_{i}", run.velocity)
    columns |= _numbered("actual_current_{i}", run.effort) | _numbered("actual_TCP_pose_{i}", run.position)
    columns |= {"robot_mode": np.full(len(run.time), 7)}
    np.savetxt(
        folder / "log.csv", np.column_stack(list(columns.values())), header=" ".join(columns), comments=""
    )
    return folder / "log.csv", _known(run, "actual_q_{i}", "actual_current_{i}", "timestamp", velocity="rad")


def rosbag(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Joint states with their names sorted, as ROS 2 controllers publish them."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    state, header, stamp = (
        kinds[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    order = np.argsort(run.joints)
    names = [run.joints[k] for k in order]
    speeds = np.zeros((len(run.time), 0)) if run.velocity is None else run.velocity[:, order]
    with Writer(folder / "bag", version=9) as bag:
        topic = bag.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for time, q, dq, effort in zip(run.time, run.position, speeds, run.effort, strict=True):
            now = round(1e9 * time) + 1_700_000_000_000_000_000
            head = header(stamp(*divmod(now, 1_000_000_000)), "")
            message = state(head, names, q[order], np.ascontiguousarray(dq), effort[order])
            bag.write(topic, now, store.serialize_cdr(message, state.__msgtype__))
    # init has a bag's signals by these names
    known = _known(run, "{j} position [rad]", "{j} torque", "time [s]")
    return folder / "bag", replace(known, velocity="" if run.velocity is None else "rad")


def parquet(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Columns of lists."""
    import pyarrow
    from pyarrow import parquet as file

    lists = {"t": run.time, "joint_angles": list(run.position), "motor_current": list(run.effort)}
    file.write_table(pyarrow.table(lists), folder / "log.parquet")
    return folder / "log.parquet", _known(run, "joint_angles{k}", "motor_current{k}", "t")


def npz(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Arrays whose joints are sorted by name, which no name tells; microseconds."""
    order = np.argsort(run.joints)
    arrays = {"t": 1e6 * run.time, "pos": run.position[:, order], "eff": run.effort[:, order]}
    np.savez(folder / "log.npz", **{"cur" if name == "eff" else name: one for name, one in arrays.items()})
    known = _known(run, "pos{k}", "cur{k}", "t", "us rad")
    for signal in ("position", "current"):
        names = known.columns[signal]
        known.columns[signal] = [names[list(order).index(k)] for k in range(run.dof)]
    return folder / "log.npz", known


def lerobot(run: Samples, folder: Path) -> tuple[Path, Known]:
    """A data set of one episode at 50 frames a second, degrees."""
    import pyarrow
    from pyarrow import parquet as file

    root, every = folder / "set", slice(None, None, 10)
    (root / "data/chunk-000").mkdir(parents=True)
    (root / "meta").mkdir()
    names = [f"{joint}.pos" for joint in run.joints]
    feature = {"dtype": "float32", "shape": [run.dof], "names": names}
    info = {"codebase_version": "v3.0", "fps": 50, "features": {"observation.state": feature}}
    (root / "meta/info.json").write_text(json.dumps(info))
    frames = np.arange(len(run.time[every]))
    columns = {
        "observation.state": list(np.degrees(run.position[every]).astype("float32")),
        "observation.current": list(run.effort[every].astype("float32")),
        "action": list(np.degrees(run.position[every]).astype("float32")),
        "timestamp": frames / 50.0,
        "frame_index": frames,
        "episode_index": np.zeros(len(frames), int),
    }
    file.write_table(pyarrow.table(columns), root / "data/chunk-000/file-000.parquet")
    return root, _known(run, "observation.state{k}", "observation.current{k}", "timestamp", "s deg")


def libfranka(run: Samples, folder: Path) -> tuple[Path, Known]:
    """What logToCSV writes, with two of its matrices."""
    columns = {"time": np.round(1e3 * run.time), **_numbered("state.q[{i}]", run.position)}
    columns |= _numbered("state.q_d[{i}]", run.position) | _numbered("state.dq[{i}]", run.velocity)
    columns |= _numbered("state.tau_J[{i}]", run.effort) | _numbered(
        "state.tau_ext_hat_filtered[{i}]", run.effort
    )
    columns |= _numbered("state.O_T_EE[{i}]", np.ones((len(run.time), 16)))
    # its stamps are whole milliseconds, and the recording's are not: those that became equal are left out
    rows = np.concatenate([[True], np.diff(columns["time"]) > 0])
    table = np.column_stack(list(columns.values()))[rows]
    np.savetxt(folder / "log.csv", table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return folder / "log.csv", _known(run, "state.q[{i}]", "state.tau_J[{i}]", units="ms rad", velocity="rad")


def savetxt(run: Samples, folder: Path) -> tuple[Path, Known]:
    """A header behind # and spaces between columns, degrees."""
    columns = {
        "t": run.time,
        **_numbered("q{i}", np.degrees(run.position)),
        **_numbered("tau{i}", run.effort),
    }
    np.savetxt(folder / "log.txt", np.column_stack(list(columns.values())), header=" ".join(columns))
    return folder / "log.txt", _known(run, "q{i}", "tau{i}", "t", "s deg")


def meaningless(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Velocities, efforts, and positions in degrees, called a, b, c."""
    import pandas

    columns = {"x": run.time, **_numbered("a{k}", run.velocity), **_numbered("b{k}", run.effort)}
    columns |= _numbered("c{k}", np.degrees(run.position))
    pandas.DataFrame(columns).to_csv(folder / "log.csv", index=False)
    return folder / "log.csv", _known(run, "c{k}", "b{k}", "x", "s deg", velocity="rad")


def nameless(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Time, positions and torques, and no line of names."""
    np.savetxt(folder / "log.csv", np.column_stack([run.time, run.position, run.effort]), delimiter=",")
    known = _known(run, "", "", "1")
    numbers = [[str(2 + run.dof * block + k) for k in range(run.dof)] for block in range(2)]
    return folder / "log.csv", replace(
        known, columns={"time": ["1"], "position": numbers[0], "torque": numbers[1]}
    )


def permille(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Motor torque in thousandths of the rated one, as whole numbers; drives 2 and 5 count backwards."""
    import pandas

    rated = np.abs(run.effort).max(axis=0) * np.where(np.isin(np.arange(run.dof), (1, 4)), -1, 1) / 800.0
    columns = {"time": run.time, **_numbered("axis{k}.actual_position", np.degrees(run.position))}
    columns |= _numbered("axis{k}.actual_torque", np.round(run.effort / rated))
    pandas.DataFrame(columns).to_csv(folder / "log.csv", index=False)
    known = _known(run, "axis{k}.actual_position", "axis{k}.actual_torque", units="s deg")
    return folder / "log.csv", replace(known, gain=run.gain * rated)


def drive_torque(run: Samples, folder: Path) -> tuple[Path, Known]:
    """Torques of motors before the gear, stamps in nanoseconds."""
    import pandas

    columns = {"stamp": 1_700_000_000_000_000_000 + np.round(1e9 * run.time).astype(int)}
    columns |= _numbered("J{k}_position", run.position) | _numbered("J{k}_torque", run.effort)
    pandas.DataFrame(columns).to_csv(folder / "log.csv", index=False)
    return folder / "log.csv", _known(run, "J{k}_position", "J{k}_torque", "stamp", "ns rad")
