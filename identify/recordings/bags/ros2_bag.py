"""Joint states from bags of ROS 2 and ROS 1, and from MCAP files of other tools; needs `exidyn[ros2]`."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.robot import Robot
from ...errors import NotRecorded, RecordingError, UnknownKey, listed
from ...model import Model
from ...notebook import counted
from ..incomplete_samples import without_damaged, without_stale
from ..recording import EFFORT, SIGNALS, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..tables.columns import Names
from ..tables.import_table import import_table
from ..tables.signal_units import Units
from ..tables.table import Table
from ..time_order import separate_runs
from .bag_reader import Content, Group, read_bag
from .joint_parts import choose_topics, clock_of, joined, names_in, parts_of


def import_ros2_bag(
    source: Path,
    model: Model,
    topic: str | None = None,
    joints: str | Sequence[str] | None = None,
    effort: str = "torque",
    payload: KnownPayload | None = None,
    preset: Path | str | None = None,
    columns: Mapping[str, Names] | None = None,
    units: Units | None = None,
    degrees: bool = False,
    rate: float | None = None,
) -> list[Recording]:
    """Import joint states, and further signals such as motor currents from topics named as in exidyn's files.

    Joints may be in different messages or on different topics; their samples are resampled at common times.
    The fields of other messages are columns of a table, if there are no joint states.

    Args:
        source: Path of the bag's folder, or of its .mcap, .db3 or .bag file.
        model: Nominal model; its joints are looked up by name.
        topic: Topic of the joint states, or several separated by commas; needed if several have all joints.
        joints: Names of the joints in the bag: one per joint, or a pattern such as "left_{joint}".
        effort: Quantity in the field effort, "torque" or "current".
        payload: Payload on the flange.
        preset: For fields of other messages, as for `import_table`.
        columns: For fields of other messages, as for `import_table`.
        units: For fields of other messages, as for `import_table`.
        degrees: For fields of other messages, as for `import_table`.
        rate: For fields of other messages, as for `import_table`.
    """
    if effort not in EFFORT:
        raise RecordingError(f"effort (--effort) '{effort}': valid are {', '.join(EFFORT)}")
    content = read_bag(source)
    of_table = {"preset": preset, "columns": columns, "units": units, "degrees": degrees, "rate": rate}
    of_table = {name: value for name, value in of_table.items() if value}
    if not content.groups:
        options = of_table | {"joints": joints, "effort": effort, "payload": payload}
        return _of_fields(source, content.tables, topic, model, options)
    if of_table:
        raise UnknownKey(
            next(iter(of_table)), "import of joint states", ("topic", "joints", "effort", "payload")
        )
    groups, names = choose_topics(source, content.groups, model.robot, topic, joints)
    parts = parts_of(groups, names)
    times, notes = clock_of(parts)
    part, time = parts[0], times[0]
    if len(parts) > 1:
        part, time, warning = joined(str(source), parts, times)
        notes.append(warning)
    _require_positions(source, groups, part, model.robot)
    signals = _signals(part, time, names, effort) | _array_signals(content, part, time)
    signals = _with_efforts(source, groups, names, signals, model.robot)
    wrong = [_wrong_length(group, field) for group in groups for field in group.wrong]
    recording = Recording(
        name=source.stem,
        model=model,
        signals=signals,
        payload=payload,
        settings={"source": source.name},
        host_time=part.received,
        warnings=(*content.notes, *wrong, *notes),
    )
    complete = without_damaged(without_stale(recording))
    return [check(run) for run, _ in separate_runs(complete, "message {}".format)]


def _of_fields(
    source: Path, tables: Sequence[Table], topic: str | None, model: Model, options: Mapping[str, Any]
) -> list[Recording]:
    """Runs of the only topic whose fields are those of the robot; errors are about the largest topic."""
    runs, errors = {}, []
    for table in sorted(tables, key=lambda table: -table.values.size):
        if topic in (None, table.run):
            try:
                runs[table.run] = import_table(_reader(table), source, model, **options)
            except RecordingError as error:
                errors.append(error)
    if not runs and not errors:
        raise RecordingError(f"{source}: no {topic}. Topics: {listed(table.run for table in tables)}")
    if not runs:
        raise errors[0]
    if len(runs) > 1:
        raise RecordingError(f"{source}: {listed(runs)} have the robot's joints; choose one by --topic TOPIC")
    return next(iter(runs.values()))


def _reader(table: Table) -> Callable[[Path], list[Table]]:
    return lambda _: [table._replace(run="")]


def joints_of_bag(source: Path) -> list[str]:
    """Names of all joints in the joint states of a bag."""
    return list(names_in(read_bag(source).groups))


def _signals(part: Group, time: np.ndarray, names: Sequence[str], effort: str) -> dict[str, Signal]:
    """Signals of joints in the robot's order at times (t,) [ns], from fields that some message has."""
    places = [part.names.index(name) for name in names]
    since = (time - time[0]) * 1e-9
    signals = {}
    for field, values in part.rows.items():
        name = effort if field == "effort" else field
        if name in SIGNALS and not np.isnan(values[:, places]).all():
            signals[name] = Signal(since, values[:, places])
    return signals


def _array_signals(content: Content, part: Group, time: np.ndarray) -> dict[str, Signal]:
    """Signals from arrays, whose times are those of the bag, converted to the clock of the joint states."""
    late = part.received[0] - time[0]
    return {
        name: Signal((received - late - time[0]) * 1e-9, values)
        for name, (received, values) in content.arrays.items()
        if not np.isnan(values).all()
    }


def _with_efforts(
    source: Path, groups: Sequence[Group], names: Sequence[str], signals: dict[str, Signal], robot: Robot
) -> dict[str, Signal]:
    """Signals without efforts that only some joints have; the effort of a joint without motor is zero.

    `names` are those of the robot's joints in the bag.
    """
    efforts = {name: signals[name] for name in EFFORT if name in signals}
    silent = {name: np.isnan(signal.values).all(axis=0) for name, signal in efforts.items()}
    fewest = min(silent.values(), key=np.sum, default=np.ones(robot.dof, bool))
    if fewest.shape == (robot.dof,):  # otherwise Recording refuses it
        lacks = fewest & ~np.isin(robot.joints, robot.passive)
        missing = [name for name, lacking in zip(names, lacks, strict=True) if lacking]
        if missing:
            raise NotRecorded(
                f"{source}: the messages have no efforts{_without(groups, 'effort', missing, robot)}. Record "
                "a topic with efforts or motor currents, or name it: --topic TOPIC"
            )
    others = {name: signal for name, signal in signals.items() if name not in EFFORT}
    usable = {name: signal for name, signal in efforts.items() if silent[name].sum() == fewest.sum()}
    return others | {
        name: Signal(signal.time, np.where(silent[name], 0.0, signal.values))
        for name, signal in usable.items()
    }


def _require_positions(source: Path, groups: Sequence[Group], part: Group, robot: Robot) -> None:
    """Require a position of every joint."""
    silent = np.isnan(part.rows["position"]).all(axis=0)
    if silent.any():
        missing = [name for name, lacks in zip(part.names, silent, strict=True) if lacks]
        sent = [name for name, values in part.rows.items() if not np.isnan(values).all()]
        raise NotRecorded(
            f"{source}: the messages have no positions{_without(groups, 'position', missing, robot)}; there: "
            f"{listed(sent)}. Record a topic with positions, or name it: --topic TOPIC"
        )


def _without(groups: Sequence[Group], field: str, missing: Sequence[str], robot: Robot) -> str:
    """Part of a message: joints that lack a field, and the reason."""
    affected = [group for group in groups if set(missing) & set(group.names)]
    wrong = [_wrong_length(group, field) for group in affected if field in group.wrong]
    count = sum(len(group.received) for group in affected)
    some = len(missing) < robot.dof
    with_them = " with them" * some
    empty = f"the field {field} of all {count} joint states{with_them} is empty or NaN"
    return f"{f' of {listed(missing)}' * some}: {wrong[0] if wrong else empty}"


def _wrong_length(group: Group, field: str) -> str:
    """Sentence about a field with fewer or more values than joints."""
    count, length = group.wrong[field]
    return (
        f"{field} has {counted(length, 'value')} for {len(group.names)} joints in {count} of "
        f"{len(group.received)} messages of {group.topic}: their joints are unknown, and they are left out"
    )
