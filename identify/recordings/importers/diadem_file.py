"""NI DIAdem DAT files, as KUKA's trace writes them: a text header beside a file of raw numbers.

A header line is `code,value`. Of each channel: 200 name, 202 unit, 210 implicit or explicit, 211 data file,
213 BLOCK (samples interleaved) or CHANNEL (one channel behind the other), 214 number type, 220 count,
221 column or first value (from 1), 240 offset and 241 factor. An implicit channel is offset + k * factor.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import NotAFile, RecordingError

TYPES = {"REAL64": "<f8", "REAL32": "<f4", "INT32": "<i4", "INT16": "<i2", "WORD16": "<u2", "WORD32": "<u4"}

LARGEST = 1e15
"""Numbers of a header are below this: above it, a double is no longer exact to the tenth."""
MOST = 10_000_000
"""Samples of a channel, at most: nearly three hours at 1 kHz, and a trace lasts minutes."""


@dataclass(frozen=True)
class DiademChannel:
    """One channel.

    Attributes:
        name: As in the file, German on most controllers.
        unit: As in the file.
        implicit: Whether the values follow from offset and factor, as time stamps do.
        values: Shape (t,), in that unit.
    """

    name: str
    unit: str
    implicit: bool
    values: np.ndarray


def read_diadem(path: Path) -> tuple[list[DiademChannel], list[str]]:
    """Read a header and the data beside it: all channels, and what is missing of their data.

    Raises:
        NotAFile: Header or data are missing, or do not match.
    """
    headers = _headers(path)
    explicit = [header for header in headers if not _implicit(header)]
    if not explicit:
        raise NotAFile(f"{path} has no channel with data")
    warnings: list[str] = []
    channels = []
    for header in headers:
        if _implicit(header):
            values = np.arange(_whole(path, header, "220", 0), dtype=float)
        else:
            values = _stored(path, header, len(explicit), warnings)
        scaled = values * _number(path, header, "241", 1.0) + _number(path, header, "240", 0.0)
        channels.append(DiademChannel(header["200"], header.get("202", ""), _implicit(header), scaled))
    return channels, list(dict.fromkeys(warnings))


def _headers(path: Path) -> list[dict[str, str]]:
    """The `code,value` lines of each channel."""
    try:
        # KUKA's headers are ISO-8859-1 (a degree sign is one byte); any byte is a character in it.
        lines = path.read_text(encoding="iso-8859-1").splitlines()
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {error.strerror}") from error
    headers: list[dict[str, str]] = []
    inside = False
    for line in map(str.strip, lines):
        if line == "#BEGINCHANNELHEADER":
            inside = True
            headers.append({})
        elif line == "#ENDCHANNELHEADER":
            inside = False
        elif inside and "," in line:
            code, value = line.split(",", 1)
            headers[-1].setdefault(code.strip(), value.strip())
    if not headers or any("200" not in header for header in headers):
        raise NotAFile(
            f"{path} is no DIAdem header: there is no channel between #BEGINCHANNELHEADER and its end"
        )
    return headers


def _implicit(header: dict[str, str]) -> bool:
    return header.get("210", "").upper().startswith("IMPLI")  # IMPLIZIT in German files, IMPLICIT in others


def _number(path: Path, header: dict[str, str], code: str, default: float) -> float:
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


def _whole(path: Path, header: dict[str, str], code: str, default: int) -> int:
    """A number of samples or of a column."""
    value = _number(path, header, code, default)
    if not 0 <= value <= MOST or value != int(value):
        raise RecordingError(
            f"{path}: channel {header['200']}: {code} is {value:g}; expected a whole number from 0 to {MOST}"
        )
    return int(value)


def _stored(path: Path, header: dict[str, str], width: int, warnings: list[str]) -> np.ndarray:
    """Values of one channel before offset and factor; fewer than the header states if data are cut off."""
    data = _data_file(path, header)
    kind = header.get("214", "REAL64").upper()
    if kind not in TYPES:
        raise RecordingError(f"{path}: channel {header['200']} is {kind}. Read are {', '.join(TYPES)}")
    raw = np.fromfile(data, TYPES[kind])  # leaves out a number that is cut in the middle
    count, place = _whole(path, header, "220", 0), _whole(path, header, "221", 1) - 1
    layout = header.get("213", "BLOCK").upper()
    if layout == "CHANNEL" and place >= 0:
        values = raw[place : place + count]
    elif 0 <= place < width:
        values = raw[: len(raw) // width * width].reshape(-1, width)[:count, place]
    else:
        raise RecordingError(f"{path}: channel {header['200']} is column {place + 1} of {width}")
    if len(values) < count:
        warnings.append(f"{data.name} ends abruptly: {len(values)} of {count} samples are there")
    return values.astype(float)


def _data_file(path: Path, header: dict[str, str]) -> Path:
    """The data file beside the header: as named there, or called like the header."""
    named = header.get("211", "").replace("\\", "/").rsplit("/", 1)[-1].lower()
    beside = {file.name.lower(): file for file in path.parent.iterdir()}
    for name in (named, f"{path.stem}.r64".lower()):
        if name in beside and name:
            return beside[name]
    raise NotAFile(f"{path} names {named or 'no data file'}, which is not beside it, nor is {path.stem}.r64")
