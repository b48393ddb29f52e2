"""From a table of named columns to a recording: which column is which signal, and in what unit."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ....errors import NotAFile, NotFinite, RecordingError, WrongShape
from ....model import Model
from ....text_table import digits
from ...optional_signals import without_damaged
from ...recording import EFFORT, SIGNALS, KnownPayload, Recording, Signal
from ...recording_checks import check
from ...separate_runs import separate_runs
from ...servo_error import (
    COMMAND,
    LAW,
    clipped_words,
    lacks_effort,
    servo_of,
    servo_words,
    with_servo_error,
)
from ...units import ANGLES, factors, joint_side, to_axes_of_robot
from ...wrong_unit import percent_questions
from .columns import Columns, Names
from .preset import Preset, Reading, preset_for, read_preset
from .table import Table


def import_table(
    read: Callable[[Path], list[Table]],
    source: Path,
    model: Model | None = None,
    preset: Path | str | None = None,
    columns: Mapping[str, Names] | None = None,
    joints: Names | None = None,
    effort: str = "torque",
    servo_gain: float | None = None,
    servo_limit: float | None = None,
    degrees: bool = False,
    motor_side: bool | Sequence[str] = False,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    time_scale: float | None = None,
    skip_rows: int = 0,
    name: str | None = None,
    payload: KnownPayload | None = None,
    settings: Mapping[str, str] | None = None,
) -> list[Recording]:
    """Import the runs of one file; irregular time stamps stay as they are.

    Args:
        read: Reads the file.
        source: The file, or the folder of a data set.
        model: The nominal robot.
        preset: File with the names, units and signs of the columns, or name of one that comes with exidyn;
            by default preset.toml beside the file, or one of exidyn's that has its columns.
        columns: Where the names are others: "time" -> column; signal -> list of columns, one a joint, or
            a pattern with {number}, {index} or {joint} in it, such as "axis{number}_current".
        joints: What the joints are called in the file: one name a joint, or a pattern such as "left_{joint}".
        effort: What a column of effort holds, "torque" or "current"; or "command", where the servo's error
            takes the place of the current, as it does where the robot's drives are servos and the file has
            no effort.
        servo_gain: By which that is multiplied, as of a servo whose gain differs from run to run; by default
            the robot's.
        servo_limit: At which the servo gives all it can, `servo_gain` included; by default the robot's.
        degrees: Positions and velocities are in degrees and degrees a second.
        motor_side: Positions, velocities and torques are the motor's, before the gear; or which of them.
        sign: 1 or -1 a joint, where the controller counts the other way than the robot's description.
        zero: Position in the robot's description where the controller shows zero [rad], one a joint.
        time_scale: Seconds per unit of the time column.
        skip_rows: Rows to leave out at the beginning, where a recorder had not yet settled.
        name: Name of the run; that of the file by default.
        payload: What hung on the flange.
        settings: Whatever else explains the run.

    Raises:
        RecordingError: The file does not hold a run of this robot; the message gives the reason.
        RobotError: The preset is wrong.
    """
    if model is None:
        raise RecordingError(f"{source}: a table does not name its robot; give the robot too (--robot FILE)")
    if effort not in (*EFFORT, COMMAND):
        raise RecordingError(f"effort (--effort) '{effort}': valid are {', '.join((*EFFORT, COMMAND))}")
    by_servo, effort = effort == COMMAND, EFFORT[0] if effort == COMMAND else effort
    given = read_preset(preset) if preset else None
    chosen = _chosen(columns or {}, effort)
    stem = _stem(source)
    recordings = []
    for table in read(source):
        table = table.without(skip_rows)
        if not len(table.values):
            raise NotAFile(f"{source} has no samples behind the {skip_rows} rows to skip (--skip-rows)")
        found = Columns(source, table, model.robot, joints)
        used = (given or preset_for(source, found)).of_log(found, chosen, effort)
        _check_still(table, used, source)
        signals, stamps = _signals(found, used, chosen, time_scale, degrees)
        known = {"source": source.name, "first_time_stamp_s": repr(float(stamps[0]))}
        known |= {"preset": used.name} if used.name else {}
        if by_servo or lacks_effort(signals, model.robot):
            servo = servo_of(model.robot, servo_gain, servo_limit)
            signals = with_servo_error(signals, servo, str(source))
            known |= {LAW: servo_words(servo)}
            found.left_out.extend(clipped_words(signals, servo, model.robot.joints))
        recording = Recording(
            name=f"{name or stem}{table.run and '/'}{table.run}",
            model=model,
            signals=signals,
            payload=payload,
            settings={**known, **(settings or {})},
        )
        recording = without_damaged(recording.with_warnings(*found.left_out))
        if degrees or used.in_degrees:
            position = recording.signals["position"].values
            recording = recording.with_warnings(*percent_questions(model.robot, position))
        recording = to_axes_of_robot(joint_side(recording, motor_side), sign, zero)
        for run, first in separate_runs(recording, table.place, table.headings()):
            recordings.append(_checked(run, source, table.without(first), stamps[first:]))
    return recordings


def _stem(source: Path) -> str:
    """Name of the run: that of the file without its ending, or of the folder.

    Raises:
        NotAFile: The system takes no such path.
    """
    try:
        is_file = source.is_file()
    except OSError as error:
        raise NotAFile(f"{source} cannot be read: {error.strerror}") from error
    return source.name.removesuffix(".gz").rsplit(".", 1)[0] if is_file else source.name


def _signals(
    found: Columns, used: Preset, chosen: Mapping[str, Names], time_scale: float | None, degrees: bool
) -> tuple[dict[str, Signal], np.ndarray]:
    """Signals of a table, their time from the first stamp on, and all stamps (t,) [s]."""
    names = {**{signal: one.column for signal, one in used.signals.items()}, **chosen}
    where = f"{found.source} (preset {Path(used.name).name})" if used.name else str(found.source)
    time = None if used.rate and "time" not in chosen else found.time(names, where)
    # Numbers count joints that the robot does not have where some are still.
    places = found.signals(names, chosen, not used.still, where)
    stamps = _stamps(found, time, used, time_scale)
    signals = {
        signal: Signal(stamps - stamps[0], _values(found, where, signal, used, degrees))
        for signal, where in places.items()
    }
    return signals, stamps


def _checked(recording: Recording, source: Path, table: Table, stamps: np.ndarray) -> Recording:
    """The recording, if it is plausible; what is not finite is named by its place in the file."""
    try:
        return check(recording)
    except NotFinite as error:
        if error.time is None:
            raise
        row = table.place(int(np.argmin(np.abs(stamps - stamps[0] - error.time))))
        raise NotFinite(f"{source} {row}: {error}", error.time) from error


def _chosen(columns: Mapping[str, Names], effort: str) -> dict[str, Names]:
    """Columns as they were named, by signal."""
    unknown = [key for key in columns if key not in ("time", "effort", *SIGNALS)]
    if unknown:
        raise WrongShape(
            f"columns (--columns): unknown {', '.join(unknown)}. Valid: time, {', '.join(SIGNALS)}, effort"
        )
    return {effort if key == "effort" else key: names for key, names in columns.items()}


def _check_still(table: Table, used: Preset, source: Path) -> None:
    """Make sure that joints which the model holds stand where they stood.

    Raises:
        WrongShape: One moves, or its column is not there.
    """
    for column, (low, high) in used.still.items():
        if column not in table.names:
            raise WrongShape(f"{source}: no column {column}, which preset {used.name} says stands still")
        values = table.values[:, table.names.index(column)]
        lowest, highest = np.nanmin(values, initial=np.inf), np.nanmax(values, initial=-np.inf)
        if lowest < low or highest > high:
            raise WrongShape(
                f"{source}: column {column} goes from {digits(lowest)} to {digits(highest)}, but its joint "
                f"is held between {digits(low)} and {digits(high)} by preset {used.name} and the robot's "
                "description. Make both anew from all logs: exidyn init LOG LOG ..., with --force"
            )


def _stamps(found: Columns, column: int | None, used: Preset, scale: float | None) -> np.ndarray:
    """The time stamps, shape (t,) [s], if they can be those of a run."""
    source, table = found.source, found.table
    if len(table.values) < 2:
        raise NotAFile(f"{source} has one sample, in {table.place(0)}; a run has many")
    if column is None:
        return np.arange(len(table.values)) / used.rate
    stamps = table.values[:, column]
    if scale is None:
        reading = used.signals.get("time", Reading(""))
        scale = factors(["s"], reading.unit, f"{used.name}: time")[0][0]
    bad = np.flatnonzero(~np.isfinite(stamps))
    if len(bad):
        raise NotFinite(
            f"{source} {table.place(bad[0])}: no time stamp; leave such rows out ({len(bad)} in all)"
        )
    return stamps * scale


def _values(found: Columns, places: list[int], signal: str, used: Preset, degrees: bool) -> np.ndarray:
    """A signal in the unit of `SIGNALS`, shape (t, n); NaN for a joint without a column."""
    robot, reading = found.robot, used.signals.get(signal, Reading(""))
    si, where = robot.units(SIGNALS[signal]), f"{used.name}: {signal}"
    factor, offset = factors(si, reading.unit, where)
    if degrees:
        factor = np.where(np.isin(si, ANGLES), np.pi / 180, factor)
    if len(reading.signs) not in (1, robot.dof):
        raise WrongShape(f"{where}: {len(reading.signs)} signs, but {robot.name} has {robot.dof} joints")
    picked = found.table.values[:, [max(place, 0) for place in places]]
    picked[:, [place < 0 for place in places]] = np.nan
    return reading.signs * (picked * factor + offset)
