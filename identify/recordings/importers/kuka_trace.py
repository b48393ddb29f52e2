"""Traces of KUKA controllers: <name>_KRCIpo and <name>_NextGenDrive#1 to #6, each a .dat with a .r64.

These are NI DIAdem files: a text header beside a file of raw numbers. A header line is `code,value`. Codes of
a channel are: 200 name, 202 unit, 210 implicit or explicit, 211 data file, 213 BLOCK (samples interleaved) or
CHANNEL (channels consecutive), 214 number type, 220 count, 221 column or first value (from 1), 240 offset and
241 factor. An implicit channel is offset + k * factor.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import NotAFile, RecordingError
from ...file_names import read_failure
from ...model import Model
from ..recording import ControllerState, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..units import UNITS, joint_side, to_axes_of_robot, unit_named

CHANNELS: dict[str, str] = {
    "istposition": "position",
    "axispos_act": "position",
    "iststrom": "current",
    "istmoment": "torque",
    "motortemperatur": "temperature",
    "sollposition": "command",
    "axispos_cmdipo": "command",
}
"""Beginning of a channel's name -> signal; the number of the axis follows it, or is in the file's name.
If both a drive and the interpolator have a signal, the drive's is used, since it is sampled faster."""
ARM_AXES = 6
"""Number of axes that a KUKA controller reserves for the arm; the seventh is the external axis E1."""
Header = dict[str, str]
"""Codes of a channel and their values; the name is in German on most controllers."""
TYPES = {"REAL64": "<f8", "REAL32": "<f4", "INT32": "<i4", "INT16": "<i2", "WORD16": "<u2", "WORD32": "<u4"}

LARGEST = 1e15
"""Limit of numbers in a header: above it, a double is no longer exact to a tenth."""
MOST = 10_000_000
"""Maximum number of samples of a channel: nearly three hours at 1 kHz, while a trace lasts minutes."""


@dataclass(frozen=True)
class _Column:
    """One signal of one axis: rank 0 from a drive, 1 from the interpolator."""

    signal: str
    axis: int
    rank: int
    time: np.ndarray
    values: np.ndarray


def import_kuka_trace(
    source: Path,
    model: Model,
    motor_side: bool | Sequence[str] = False,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    name: str | None = None,
    payload: KnownPayload | None = None,
) -> list[Recording]:
    """Import traces: all files with the same name are one run, and each signal keeps its own rate.

    Args:
        source: Path of a folder, or of any file of one trace.
        model: Nominal model.
        motor_side: Signals that the controller records before the gear, such as ["torque"].
        sign: 1 or -1 per joint: direction of the controller's axis relative to the robot's description.
        zero: Position in the robot's description at the controller's zero, one per joint [rad].
        name: Name of the trace in a folder of several; by default all traces.
        payload: Payload on the flange.
    """
    folder = source if source.is_dir() else source.parent
    traces: dict[str, list[Path]] = {}
    for file in sorted(folder.iterdir()):
        if file.suffix.lower() == ".dat":
            traces.setdefault(_trace_name(file), []).append(file)
    wanted = name or (None if source.is_dir() else _trace_name(source))
    selected = {trace: files for trace, files in traces.items() if wanted in (None, trace)}
    if not selected:
        raise NotAFile(f"{source}: no trace {wanted or ''}. Traces here: {', '.join(traces) or 'none'}")
    runs = [_recording(trace, files, model, payload) for trace, files in selected.items()]
    return [check(to_axes_of_robot(joint_side(run, motor_side), sign, zero)) for run in runs]


def _trace_name(file: Path) -> str:
    return re.sub(r"_(KRCIpo|NextGenDrive#?\d*)$", "", file.stem, flags=re.IGNORECASE)


def _recording(trace: str, files: list[Path], model: Model, payload: KnownPayload | None) -> Recording:
    warnings: list[str] = []
    columns = [column for file in files for column in _columns(file, warnings)]
    arm_axes = max(ARM_AXES, model.robot.dof)
    external = [column for column in columns if column.axis > arm_axes]
    by_signal: dict[str, list[_Column]] = {}
    for column in columns:
        if column.axis <= arm_axes:
            by_signal.setdefault(column.signal, []).append(column)
    signals = {name: _signal(name, sharing, model, warnings) for name, sharing in by_signal.items()}
    settings = {"source": ", ".join(file.name for file in files)}
    state = _external(external, arm_axes, warnings)
    return Recording(
        trace, model, signals, payload, settings=settings, warnings=tuple(warnings), controller=state
    )


def _external(columns: list[_Column], arm_axes: int, warnings: list[str]) -> ControllerState | None:
    """External axes, which are not in the model, on the time axis of the first; None if there are none."""
    if not columns:
        return None
    columns = sorted(columns, key=lambda column: (column.axis, column.signal, column.rank))
    named = {f"{column.signal} E{column.axis - arm_axes}": column for column in reversed(columns)}
    names, time = sorted(named), columns[0].time
    values = [np.interp(time, named[name].time, named[name].values, np.nan, np.nan) for name in names]
    warnings.append(f"external axes are kept, and not identified: {', '.join(names)}")
    return ControllerState(time, np.transpose(values), {name: {} for name in names})


def _columns(file: Path, warnings: list[str]) -> list[_Column]:
    channels = _read_diadem(file, warnings)
    number = re.search(r"#(\d+)$", file.stem)
    times = [channel for channel in channels if _implicit(channel[0])]
    if not times:
        raise RecordingError(f"{file} has no implicit channel of time")
    time = _in_si(*times[0], warnings)
    columns = []
    for header, numbers in channels:
        match = re.match(r"([a-z_]+?)[ _#]*a?(\d*)$", header["200"].lower())
        signal = CHANNELS.get(match[1]) if match else None
        axis = match[2] if match and match[2] else (number[1] if number else "")
        values = _in_si(header, numbers, warnings) if signal and axis else None
        if signal and values is not None and time is not None:
            shown = min(len(time), len(values))
            columns.append(_Column(signal, int(axis), 0 if number else 1, time[:shown], values[:shown]))
    return columns


def _in_si(header: Header, numbers: np.ndarray, warnings: list[str]) -> np.ndarray | None:
    """Numbers of a channel (t,) in SI units; None, and a warning, for an unknown unit."""
    name, unit = header["200"], header.get("202", "")
    entry = unit_named(unit)
    if entry is None:
        warnings.append(f"{name} was left out: its unit is '{unit}', known are {', '.join(UNITS)}")
        return None
    _, factor, offset = entry
    return numbers * factor + offset


def _signal(name: str, columns: list[_Column], model: Model, warnings: list[str]) -> Signal:
    """Signal with all axes, from the columns of the best rank; an axis that was not traced is NaN."""
    robot, best = model.robot, min(column.rank for column in columns)
    columns = [column for column in columns if column.rank == best]
    beyond = [column.axis for column in columns if not 1 <= column.axis <= robot.dof]
    if beyond:
        raise RecordingError(f"{name} of axis {beyond[0]}, but {robot.name} has {robot.dof}")
    length = min(len(column.time) for column in columns)
    if any(len(column.time) > length for column in columns):
        warnings.append(
            f"{name}: the files of the axes have different lengths; samples after {length} are left out"
        )
    time = columns[0].time[:length]
    for column in columns:
        if not np.allclose(column.time[:length], time, atol=1e-6):
            raise RecordingError(
                f"{name}: axes {columns[0].axis} and {column.axis} were sampled at different times"
            )
    values = np.full((length, robot.dof), np.nan)
    for column in columns:
        values[:, column.axis - 1] = column.values[:length]
    return Signal(time, values)


def _read_diadem(path: Path, warnings: list[str]) -> list[tuple[Header, np.ndarray]]:
    """Header and numbers (t,) of all channels, and warnings about missing data."""
    headers = _headers(path)
    explicit = [header for header in headers if not _implicit(header)]
    if not explicit:
        raise NotAFile(f"{path} has no channel with data")
    channels, missing = [], list[str]()
    for header in headers:
        if _implicit(header):
            values = np.arange(_whole_number(path, header, "220", 0), dtype=float)
        else:
            values = _stored(path, header, len(explicit), missing)
        scaled = values * _number(path, header, "241", 1.0) + _number(path, header, "240", 0.0)
        channels.append((header, scaled))
    warnings += dict.fromkeys(missing)
    return channels


def _headers(path: Path) -> list[Header]:
    """Codes and values of each channel in a header."""
    try:
        # KUKA's headers are ISO-8859-1 (a degree sign is one byte), in which any byte is a character.
        text = path.read_text(encoding="iso-8859-1")
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {read_failure(path, error)}") from error
    headers: list[Header] = []
    for block in text.split("#BEGINCHANNELHEADER")[1:]:
        lines = block.partition("#ENDCHANNELHEADER")[0].splitlines()
        codes = [line.partition(",") for line in lines if "," in line]
        headers.append(
            {code.strip(): value.strip() for code, _, value in reversed(codes)}
        )  # the first counts
    if not headers or any("200" not in header for header in headers):
        raise NotAFile(
            f"{path} is not a DIAdem header: it has no channel between #BEGINCHANNELHEADER and its end"
        )
    return headers


def _implicit(header: Header) -> bool:
    return header.get("210", "").upper().startswith("IMPLI")  # IMPLIZIT in German files, IMPLICIT in others


def _number(path: Path, header: Header, code: str, default: float) -> float:
    text = header.get(code, "")
    try:
        value = float(text) if text else default
    except ValueError:
        value = np.nan
    if not abs(value) < LARGEST:
        raise RecordingError(
            f"{path}: channel {header['200']}: {code} is '{text}', not a number below {LARGEST:g}"
        )
    return value


def _whole_number(path: Path, header: Header, code: str, default: int) -> int:
    """Number of samples or of a column in a header."""
    value = _number(path, header, code, default)
    if not 0 <= value <= MOST or value != int(value):
        raise RecordingError(
            f"{path}: channel {header['200']}: {code} is {value:g}; expected a whole number from 0 to {MOST}"
        )
    return int(value)


def _stored(path: Path, header: Header, width: int, warnings: list[str]) -> np.ndarray:
    """Values of a channel before offset and factor; fewer than the header states if data are cut off."""
    data = _data_file(path, header)
    kind = header.get("214", "REAL64").upper()
    if kind not in TYPES:
        raise RecordingError(f"{path}: channel {header['200']} is {kind}. Valid: {', '.join(TYPES)}")
    stored = np.fromfile(data, TYPES[kind])  # skips a number that is cut in the middle
    count, place = _whole_number(path, header, "220", 0), _whole_number(path, header, "221", 1) - 1
    layout = header.get("213", "BLOCK").upper()
    if layout == "CHANNEL" and place >= 0:
        values = stored[place : place + count]
    elif 0 <= place < width:
        values = stored[: len(stored) // width * width].reshape(-1, width)[:count, place]
    else:
        raise RecordingError(f"{path}: channel {header['200']} is column {place + 1} of {width}")
    if len(values) < count:
        warnings.append(f"{data.name} ends abruptly: {len(values)} of {count} samples are present")
    return values.astype(float)


def _data_file(path: Path, header: Header) -> Path:
    """Data file beside the header: named in the header, or with the same name as the header."""
    named = header.get("211", "").replace("\\", "/").rsplit("/", 1)[-1].lower()
    beside = {file.name.lower(): file for file in path.parent.iterdir()}
    for name in (named, f"{path.stem}.r64".lower()):
        if name in beside and name:
            return beside[name]
    raise NotAFile(f"{path} names {named or 'no data file'}, which is not beside it, nor is {path.stem}.r64")
