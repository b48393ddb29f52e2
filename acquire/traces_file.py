"""traces.npz: the samples behind a diagnosis, for those who look at it later."""

import zipfile
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from exidyn.identify.diagnosis.trace import Evidence, Trace
from exidyn.identify.errors import NotAFile
from exidyn.identify.model import Model
from exidyn.identify.robot_file import model_text, parse_model

NAME = "traces.npz"
"""Beside diagnosis.json."""
WORDS = ("name", "role")
EXACT = ("time",)
"""What single precision would round: it keeps a torque to a ten-millionth, and a nanosecond of nothing."""


class Traces(NamedTuple):
    """What is left of every run, and of which arm.

    Attributes:
        model: As believed.
        noise: Noise floor of each joint's torque behind the filter, shape (n,) [N m].
        traces: Runs held out first.
    """

    model: Model
    noise: np.ndarray
    traces: tuple[Trace, ...]


def write_traces(evidence: Evidence, path: Path) -> None:
    """Write them."""
    arrays: dict[str, Any] = {"model": np.array(model_text(evidence.model)), "noise": evidence.noise}
    for place, trace in enumerate(evidence.traces):
        for one in fields(Trace):
            value = np.asarray(getattr(trace, one.name))
            small = one.name not in (*WORDS, *EXACT)
            arrays[f"{place}.{one.name}"] = value.astype(np.float32) if small else value
    with open(path, "wb") as file:
        np.savez_compressed(file, **arrays)


def read_traces(path: Path) -> Traces:
    """Read them.

    Raises:
        NotAFile: Cut off, or something else.
    """
    try:
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            count = len({name.partition(".")[0] for name in file.files if "." in name})
            traces = tuple(_trace(file, place) for place in range(count))
            return Traces(parse_model(str(file["model"])), file["noise"], traces)
    except (KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise NotAFile(f"{path} is no file of traces, or was cut off: {error}") from error


def _trace(file: np.lib.npyio.NpzFile, place: int) -> Trace:
    values: dict[str, Any] = {}
    for one in fields(Trace):
        value = file[f"{place}.{one.name}"]
        values[one.name] = str(value) if one.name in WORDS else value.astype(float)
    return Trace(**values)
