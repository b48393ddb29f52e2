"""fit.json: a fit stored in full precision, in a format that other programs can read too.

The file is complete: model (as robot.toml), base parameters and their composition, values, covariance, drive
gains, filters, priors, warnings. Of the comparison with runs, it stores only the scores of each joint; the
samples are in the recordings. A fit read from a file therefore has `scores` and no `agreement`. `Fit.agree`
computes the agreement again, with the same prediction.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import to_builtins

from ..effects import Parameter
from ..errors import NotAFile, RobotError
from ..file_names import other_format, read_failure, write_whole
from ..model import Model
from ..result_file import from_table
from ..robot_files.robot_file import model_text, parse_model
from ..schema import Disagreement
from .agreement import Agreement
from .base_parameters import BaseParameters
from .estimators import Estimate
from .fit import Fit
from .fit_schema import SAME, SCORES, BaseParameterRow, FitFile, check_with_model

FORMAT = 1
"""Format version, increased when a reader of the previous version would misinterpret a file."""


def write_fit(fit: Fit, path: Path | str) -> Path:
    """Write the fit as JSON for `ex.read_fit`; returns the path.

    The file appears under its name only when it is complete.
    """
    return write_whole(path, fit_text(fit))


def fit_text(fit: Fit) -> str:
    """Text of fit.json, one line per entry so that two fits can be compared line by line."""
    entries = [f'"{key}": {_lines(value)}' for key, value in _table(fit).items()]
    return "{\n" + ",\n".join(entries) + "\n}\n"


def read_fit(path: Path | str) -> Fit:
    """Read fit.json.

    Raises:
        NotAFile: The file is missing, truncated, not a fit, of another format version, or has an invalid
            field, which the message names.
    """
    table = read_table(Path(path), "exidyn_fit", FORMAT, "identify RUN")
    file = from_table(table, FitFile, str(path))
    try:
        model = parse_model("\n".join(file.model))
        check_with_model(file, model)
        return _fit(file, model)
    except (RobotError, Disagreement) as error:
        raise NotAFile(f"{path}: {error}") from error


def _lines(value: Any) -> str:
    """JSON text; lists of lists and lists of tables have one line per item."""
    if isinstance(value, list) and value and isinstance(value[0], list | dict):
        return "[\n" + ",\n".join(json.dumps(item, ensure_ascii=False) for item in value) + "\n]"
    return json.dumps(value, ensure_ascii=False)


def _numbers(array: np.ndarray) -> list:
    """Nested lists of an array; infinity and NaN, which JSON does not have, are strings."""
    if array.ndim > 1:
        return [_numbers(row) for row in array]
    return [float(v) if np.isfinite(v) else str(float(v)) for v in array]


def _table(fit: Fit) -> dict[str, Any]:
    estimate, bias = fit.estimate, fit.gear_friction_bias
    return {
        "exidyn_fit": FORMAT,
        "robot": fit.model.robot.name,
        "joints": list(fit.model.robot.joints),
        "method": estimate.method,
        **to_builtins({name: getattr(fit, name) for name in SAME}, enc_hook=float),
        "drive_gain": _numbers(estimate.gain),
        "drive_gain_std": _numbers(estimate.gain_std),
        "drive_gains_nominal": estimate.nominal_gains,
        "noise": _numbers(estimate.noise),
        "noise_floor": _numbers(fit.noise),
        "noise_floor_from": fit.noise_source,
        "standstill": _numbers(fit.standstill),
        "gear_friction_bias": None if bias is None else [_numbers(row) for row in bias],
        "base_parameters": _base_parameters(fit),
        "dropped": list(fit.dropped),
        "moved": [moved.name for moved in fit.moved],
        "full_estimate": None
        if (full := fit.full_estimate) is None
        else {
            "values": _numbers(full.values),
            "drive_gain": _numbers(full.gain),
            "noise": _numbers(full.noise),
            "covariance": _numbers(full.covariance),
        },
        "gap": [float(share) for share in fit.base.gap],
        "covariance": _numbers(estimate.covariance),
        "standard_parameters": None if estimate.standard is None else _numbers(estimate.standard),
        "agreement": [_scores(a) for a in fit.agreement],
        "validation": [_scores(a) for a in fit.validation],
        "model": model_text(fit.model).split("\n"),
    }


def _base_parameters(fit: Fit) -> list[dict[str, Any]]:
    """One table per base parameter; dropped parameters have the value from before they were dropped."""
    structure, places = fit.structure or fit.base, {name: row for row, name in enumerate(fit.names)}
    std, exported, (nominal, tolerance) = fit.estimate.std, fit.exported, fit.prior
    tables = []
    for row, (name, unit) in enumerate(zip(structure.names, structure.units, strict=True)):
        place, weights = places.get(name), structure.regrouping[row]
        in_fit = place is not None
        tables.append(
            {
                "name": name,
                "unit": unit,
                "kept": in_fit,
                "value": float(fit.estimate.values[place]) if in_fit else fit.dropped[name],
                **({"std": float(std[place])} if in_fit else {}),
                **({"exported": float(exported[place])} if in_fit and exported is not None else {}),
                **({"prior": _numbers(np.array([nominal[place], tolerance[place]]))} if in_fit else {}),
                "column": int(structure.kept[row]),
                "sum_of": {p.name: float(w) for p, w in zip(structure.parameters, weights, strict=True) if w},
            }
        )
    return tables


def _scores(agreement: Agreement) -> dict[str, Any]:
    values = {name: getattr(agreement, name) for name in SCORES}
    numbers = {name: _numbers(np.where(np.isfinite(v), v, np.nan)) for name, v in values.items()}
    return {"run": agreement.run, "noise_source": agreement.noise_source} | numbers


def _fit(file: FitFile, model: Model) -> Fit:
    rows, kept_rows, parameters = file.base_parameters, file.kept, tuple(model.parameters)
    values = {row.name: row.value for row in rows}
    full, bias = file.full_estimate, file.gear_friction_bias
    prior = np.array([row.prior for row in kept_rows], float)
    return Fit(
        model=model,
        base=_base(parameters, kept_rows, file.gap),
        estimate=_estimate(file, file, [row.value for row in kept_rows], file.standard_parameters),
        prior=(prior[:, 0], prior[:, 1]),
        dropped={name: values[name] for name in file.dropped},
        structure=_base(parameters, rows, file.gap) if len(kept_rows) < len(rows) else None,
        full_estimate=None if full is None else _estimate(file, full, full.values),
        scores=(*file.agreement, *(replace(run, held_out=True) for run in file.validation)),
        noise=np.array(file.noise_floor, float),
        noise_source=file.noise_floor_from,
        standstill=np.array(file.standstill, float),
        gear_friction_bias=None if bias is None else np.array(bias, float),
        exported=None if kept_rows[0].exported is None else np.array([r.exported for r in kept_rows], float),
        **{name: getattr(file, name) for name in SAME},
    )


def _estimate(
    file: FitFile, source: Any, values: Sequence[float], standard: Sequence[float] | None = None
) -> Estimate:
    """Estimate of a file, or the one before parameters were dropped, with these values (b,)."""
    return Estimate(
        method=file.method,
        values=np.array(values, float),
        gain=np.array(source.drive_gain, float),
        covariance=np.array(source.covariance, float),
        noise=np.array(source.noise, float),
        standard=None if standard is None else np.array(standard, float),
        nominal_gains=file.drive_gains_nominal,
    )


def _base(
    parameters: tuple[Parameter, ...], rows: Sequence[BaseParameterRow], gap: tuple[float, float]
) -> BaseParameters:
    columns = {parameter.name: column for column, parameter in enumerate(parameters)}
    regrouping = np.zeros((len(rows), len(parameters)))
    for place, row in enumerate(rows):
        for name, weight in row.sum_of.items():
            regrouping[place, columns[name]] = weight
    return BaseParameters(parameters, np.array([row.column for row in rows]), regrouping, gap)


HALF = re.compile(r"\\u[dD][89a-fA-F]")
"""Escaped half of a surrogate pair; files and terminals do not accept one without the other half."""


def read_table(path: Path, key: str, valid: int, command: str) -> dict[str, Any]:
    """Table of a JSON file with the number of its format at a key; the command writes it anew.

    Raises:
        NotAFile: The file is missing, truncated, not JSON, without the key, or of another format.
    """
    table = read_json(path)
    if key not in table:
        raise NotAFile(f"{path} is not a {key.removeprefix('exidyn_')} of exidyn: it has no key '{key}'")
    if (number := table[key]) != valid:
        raise NotAFile(f"{path} has {other_format(number, valid, command)}")
    return table


def read_json(path: Path) -> dict[str, Any]:
    """Table of a JSON file; empty if the file holds something else.

    Raises:
        NotAFile: The file is missing, truncated, or not JSON.
    """
    try:
        text = path.read_text(encoding="utf-8")
        table = json.loads(text)
        if HALF.search(text):
            json.dumps(table, ensure_ascii=False).encode()
        return table if isinstance(table, dict) else {}
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {read_failure(path, error)}") from error
    except RecursionError:
        raise NotAFile(f"{path} is not valid JSON: nested too deeply") from None
    except ValueError as error:
        raise NotAFile(f"{path} is not JSON, or was cut off: {error}") from error
