"""traces.npz: the samples behind a diagnosis, for those who look at it later."""

from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exidyn.identify.diagnosis.findings.finding import Evidence, Trace
from exidyn.identify.diagnosis.improved.forward import Forward
from exidyn.identify.diagnosis.words.diagnosis_schema import DiagnosisFile
from exidyn.identify.errors import ExidynError, NotAFile
from exidyn.identify.model import Model
from exidyn.identify.robot_files.robot_file import model_text, parse_model
from exidyn.identify.schema import check

NAME = "traces.npz"
"""Beside diagnosis.json."""
WORDS = ("name", "role", "run")
EXACT = ("time",)
"""What single precision would round: it keeps a torque to a ten-millionth, and a nanosecond of nothing."""
SIMULATED = "simulated"
"""Key of what was simulated; runs have their place."""


class Traces(NamedTuple):
    """What is left of every run, and of which arm.

    Attributes:
        model: Nominal.
        noise: Noise floor of each joint's torque behind the filter, shape (n,) [N m].
        traces: Runs held out first.
        simulated: A run in simulation; None if nothing was simulated.
    """

    model: Model
    noise: np.ndarray
    traces: tuple[Trace, ...]
    simulated: Forward | None = None


def write_traces(evidence: Evidence, path: Path, simulated: Forward | None = None) -> None:
    """Write them."""
    arrays: dict[str, Any] = {"model": np.array(model_text(evidence.model)), "noise": evidence.noise}
    for place, trace in enumerate(evidence.traces):
        arrays |= _arrays(trace, str(place))
    if simulated is not None:
        arrays |= _arrays(simulated, SIMULATED)
    with open(path, "wb") as file:
        np.savez_compressed(file, **arrays)


def read_traces(path: Path) -> Traces:
    """Read them.

    Raises:
        NotAFile: Cut off, or something else, or with arrays that do not agree.
    """
    try:
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            keys = {name.partition(".")[0] for name in file.files if "." in name}
            traces = tuple(
                Trace(**_values(file, Trace, str(place))) for place in range(len(keys - {SIMULATED}))
            )
            simulated = Forward(**_values(file, Forward, SIMULATED)) if SIMULATED in keys else None
            found = Traces(parse_model(str(file["model"])), file["noise"].astype(float), traces, simulated)
            _check(found)
            return found
    except ExidynError:
        raise
    except Exception as error:  # whatever the libraries of zip, zlib and numpy stumble over
        raise NotAFile(f"{path} is no file of traces, or was cut off: {error}") from error


def traces_beside(path: Path, diagnosis: DiagnosisFile) -> Traces | None:
    """The samples behind a diagnosis, if there are any beside it.

    Args:
        path: Of diagnosis.json.
        diagnosis: What is in it.

    Raises:
        NotAFile: They are those of another, or as `read_traces`.
    """
    samples = path.with_name(NAME)
    traces = read_traces(samples) if samples.exists() else None
    if traces is None:
        return None
    others = traces.model.robot.joints != diagnosis.joints
    if others or any(len(one.explained) != len(diagnosis.every) for one in traces.traces):
        raise NotAFile(f"{samples} is of another diagnosis than {path}; diagnose again")
    return traces


def _check(found: Traces) -> None:
    """Shapes and times that agree with the model and with each other.

    Raises:
        Disagreement: With the first that does not.
    """
    joints = found.model.robot.dof
    _check_shape("noise", found.noise, (joints,))
    check(bool(np.all(found.noise > 0.0)), "noise", found.noise.tolist(), "what is above zero")
    every: list[tuple[str, Trace | Forward]] = [(str(place), one) for place, one in enumerate(found.traces)]
    if found.simulated is not None:
        every.append((SIMULATED, found.simulated))
    for key, one in every:
        _check_times(f"run {key}: time", one.time)
        rows = len(one.time)
        shapes: dict[str, tuple[int, ...]] = {"time": (rows,), "missed": (joints,)}
        if isinstance(one, Trace):
            shapes["explained"] = (len(one.explained), rows, joints)
        for name in (field.name for field in fields(one) if field.name not in (*WORDS, "left_out")):
            _check_shape(f"run {key}: {name}", getattr(one, name), shapes.get(name, (rows, joints)))


def _check_times(field: str, time: np.ndarray) -> None:
    check(time.ndim == 1 and len(time) >= 2, field, time.shape, "at least two times")
    check(
        bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0)),
        field,
        "others",
        "times that increase",
    )


def _check_shape(field: str, values: np.ndarray, shape: tuple[int, ...]) -> None:
    check(values.shape == shape, field, values.shape, f"numbers of shape {shape}")


def _arrays(one: Trace | Forward, key: str) -> dict[str, np.ndarray]:
    """All fields; what is no word and need not be exact in single precision."""
    arrays = {}
    for name in (field.name for field in fields(one)):
        value = getattr(one, name)
        if name == "left_out":
            arrays[f"{key}.{name}"] = np.array(value, dtype=str)
        elif name in (*WORDS, *EXACT):
            arrays[f"{key}.{name}"] = np.asarray(value)
        else:
            with np.errstate(over="ignore"):  # a simulation that diverged leaves single precision too
                arrays[f"{key}.{name}"] = value.astype(np.float32)
    return arrays


def _values(file: np.lib.npyio.NpzFile, kind: type[Trace] | type[Forward], key: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for name in (field.name for field in fields(kind)):
        value = file[f"{key}.{name}"]
        if name == "left_out":
            values[name] = tuple(str(word) for word in value)
        else:
            values[name] = str(value) if name in WORDS else value.astype(float)
    return values
