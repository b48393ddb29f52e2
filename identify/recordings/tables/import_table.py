"""Import of a table: signals and units of its columns, and the recording of each run."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import NotAFile, NotFinite, RecordingError, WrongShape
from ...file_names import read_failure
from ...model import Model
from ...text_table import digits
from ..effort_checks import without_unmeasured
from ..hints import import_with_hints
from ..incomplete_samples import without_damaged, without_incomplete
from ..recording import EFFORT, SIGNALS, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..servo_error import COMMAND, LAW, clipped_words, lacks_effort, servo_of, servo_words, with_servo_error
from ..time_order import separate_runs
from ..units import joint_side, to_axes_of_robot
from .columns import EFFORT_MEANS, Columns, Names
from .preset import Preset, preset_for, read_preset
from .signal_units import SignalUnits, Units, stamped, with_rate
from .table import Table


def import_table(
    read: Callable[[Path], list[Table]],
    source: Path,
    model: Model,
    preset: Preset | Path | str | None = None,
    columns: Mapping[str, Names] | None = None,
    joints: Names | None = None,
    effort: str = "torque",
    servo_gain: float | None = None,
    servo_limit: float | None = None,
    degrees: bool = False,
    units: Units | None = None,
    rate: float | None = None,
    motor_side: bool | Sequence[str] = False,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    skip_rows: int = 0,
    name: str | None = None,
    payload: KnownPayload | None = None,
    settings: Mapping[str, str] | None = None,
    in_si: bool = True,
) -> list[Recording]:
    """Import the runs of one file; irregular time stamps are preserved.

    Args:
        read: Function that reads the file.
        source: Path of the file, or of the folder of a data set.
        model: Nominal model.
        preset: File with the names, units and signs of the columns, or name of a built-in preset; by default
            preset.toml beside the file, or a built-in preset that matches the columns.
        columns: Names of columns that are not found by default: "time" -> column; signal -> list of columns,
            one per joint, or a pattern with {number}, {index} or {joint}, such as "axis{number}_current".
        joints: Names of the joints in the file: one per joint, or a pattern such as "left_{joint}".
        effort: Quantity in a column of effort, "torque" or "current"; or "command", if the servo error
            replaces the current. It also does if the drives are servos and the file has no effort.
        servo_gain: Factor of the servo error, for a servo whose gain differs from run to run; by default the
            robot's.
        servo_limit: Servo error, times `servo_gain`, at which the servo saturates; by default the robot's.
        degrees: Whether positions and velocities are in degrees and degrees per second.
        units: "time" -> unit of the time column; signal -> unit of its columns, one for all joints or one per
            joint, which overrides units in the preset or file. "%" and "0-100%" are shares of a joint's
            travel between its limits. Commands have the unit of the measured quantity, unless their unit is
            stated.
        rate: Sampling rate of a file without time [Hz].
        motor_side: Whether positions, velocities and torques are those of the motor, before the gear; or the
            names of such signals.
        sign: 1 or -1 per joint: direction of the controller's axis relative to the robot's description.
        zero: Position in the robot's description at the controller's zero, one per joint [rad].
        skip_rows: Number of rows to skip below the names, recorded before the recorder settled.
        name: Name of the run; by default that of the file.
        payload: Payload on the flange.
        settings: Further information about the run.
        in_si: Whether units are known; otherwise, values that are impossible in SI units cause warnings.

    Raises:
        RecordingError: The file holds no run of this robot; the message gives the reason.
        RobotError: The preset is wrong.
    """
    if effort not in (*EFFORT, COMMAND):
        raise RecordingError(f"effort (--effort) '{effort}': valid are {', '.join((*EFFORT, COMMAND))}")
    by_servo, effort = effort == COMMAND, EFFORT_MEANS if effort == COMMAND else effort
    stated_preset = read_preset(preset) if isinstance(preset, str | Path) else preset
    chosen = _by_signal(columns or {}, effort, "columns (--columns)")
    stated = _by_signal(units or {}, effort, "units (--units)")
    time_unit = str(stated.pop("time", ""))
    stem = _stem(source)
    recordings = []
    for table in read(source):
        table = table.without(skip_rows)
        if not len(table.values):
            raise NotAFile(f"{source} has no samples behind the {skip_rows} rows to skip (skip_rows)")
        lookup = Columns(source, table, model.robot, joints, effort)
        used = (stated_preset or preset_for(source, lookup)).of_log(lookup, chosen, effort)
        _check_still(table, used, source)
        used = with_rate(used, lookup, chosen, rate) if rate else used
        table, stamps, signals, facts = _in_si(lookup, used, chosen, stated, time_unit, degrees)
        _require_meant(signals, effort, source)
        known = {"source": source.name, "first_time_stamp_s": repr(float(stamps[0]))}
        known |= {"preset": used.name} if used.name else {}
        if by_servo or lacks_effort(signals, model.robot):
            servo = servo_of(model.robot, servo_gain, servo_limit)
            signals = with_servo_error(signals, servo, str(source))
            known |= {LAW: servo_words(servo)}
            facts += clipped_words(signals, servo, model.robot.joints)
        recording = Recording(
            name=f"{name or stem}{table.run and '/'}{table.run}",
            model=model,
            signals=signals,
            payload=payload,
            settings={**known, **(settings or {})},
        )
        recording = without_damaged(without_unmeasured(recording.with_warnings(*facts)))
        recording = without_incomplete(recording, str(source))
        recording = to_axes_of_robot(joint_side(recording, motor_side), sign, zero)
        for run, first in separate_runs(recording, table.place, table.headings()):
            recordings.append(_checked(run, source, table.without(first), stamps[first:], in_si))
    return recordings


def _in_si(
    lookup: Columns,
    used: Preset,
    chosen: Mapping[str, Names],
    stated: Units,
    time_unit: str,
    degrees: bool,
) -> tuple[Table, np.ndarray, dict[str, Signal], list[str]]:
    """Rows of a table with a time, their time stamps (t,) [s], its signals, and facts about their reading."""
    where = f"{lookup.source} (preset {Path(used.name).name})" if used.name else str(lookup.source)
    names: dict[str, Names] = {name: r.column for name, r in used.signals.items() if r.column}
    names |= chosen
    clock = None if used.rate and "time" not in chosen else lookup.time(names, where)
    # If some joints are held, the numbers in names count joints that the robot does not have.
    usual = () if used.still else used.usual(SIGNALS)
    # A preset that states columns, such as that of init, may leave others out.
    places = lookup.signals(names, chosen, usual, where, len(names) == len(chosen))
    table, stamps, facts = stamped(lookup, used, clock, time_unit)
    in_si = SignalUnits(lookup, used, places, stated, degrees)
    signals = in_si.signals(stamps - stamps[0], table.values)
    questions = in_si.percent_questions(signals["position"].values)
    return table, stamps, signals, [*lookup.left_out, *facts, *in_si.facts, *questions]


def _require_meant(signals: Mapping[str, Signal], effort: str, source: Path) -> None:
    """Refuse an option for the meaning of effort if there is none of that meaning."""
    if effort != EFFORT_MEANS and effort not in signals and EFFORT_MEANS in signals:
        raise RecordingError(
            f"{source} has no columns of effort, to which --effort {effort} would apply; name those of "
            f"{effort} by --columns {effort}=NAME,NAME,..."
        )


def from_dataframe(table: Any, robot: Model, name: str = "table", **options: Any) -> list[Recording]:
    """Runs of a pandas table, whose columns are read like those of a file.

    Args:
        table: The table; an index with a name is a column too.
        robot: Model of the recorded arm.
        name: Name of the run.
        options: Options of `import_table`, such as the names of the columns.

    Raises:
        RecordingError: The table holds no run of this robot; the message gives the reason.
    """
    columns = table.reset_index() if table.index.name else table
    names = [str(column) for column in columns.columns]
    values = columns.to_numpy(dtype=float)
    read = partial(import_table, lambda _: [Table(names, values)])
    return import_with_hints(read, Path(name), robot, {"name": name, **options})


def import_values(
    names: Sequence[str], values: np.ndarray, source: str, model: Model, **options: Any
) -> list[Recording]:
    """Runs of c named columns (t, c), with options of `import_table`; `source` names the log in messages."""
    return import_table(lambda _: [Table([*names], values)], Path(source), model, **options)


def _stem(source: Path) -> str:
    """Name of the run: name of the file without its ending, or of the folder."""
    try:
        is_file = source.is_file()
    except OSError as error:
        raise NotAFile(f"{source} cannot be read: {read_failure(source, error)}") from error
    return source.name.removesuffix(".gz").rsplit(".", 1)[0] if is_file else source.name


def _checked(recording: Recording, source: Path, table: Table, stamps: np.ndarray, in_si: bool) -> Recording:
    """The recording, if it is plausible; an error about a number that is not finite names its row."""
    try:
        return check(recording, in_si)
    except NotFinite as error:
        if error.time is None:
            raise
        row = table.place(int(np.argmin(np.abs(stamps - stamps[0] - error.time))))
        raise NotFinite(f"{source} {row}: {error}", error.time) from error


def _by_signal(stated: Mapping[str, Names], effort: str, option: str) -> dict[str, Names]:
    """Values of an option by signal; the key "effort" is replaced by the signal `effort`."""
    valid = ("time", *SIGNALS, "effort")
    if unknown := [key for key in stated if key not in valid]:
        raise WrongShape(f"{option}: unknown {', '.join(unknown)}. Valid: {', '.join(valid)}")
    return {effort if key == "effort" else key: value for key, value in stated.items()}


def _check_still(table: Table, used: Preset, source: Path) -> None:
    """Require that joints which the model holds stay within the range in the preset."""
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
