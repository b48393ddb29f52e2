"""fit.json: a fit that reads back to the last digit, and that other programs can read too.

What a fit is, is complete: model (a robot.toml inside), base parameters and how they are composed,
values, covariance, drive gains, filters, priors, warnings. Of the comparison with runs only the numbers
of each joint are kept; the samples are in the recordings. A fit that was read therefore has `scores` and
no `agreement`: `Fit.agree` makes it anew, and predicts the same as before.
"""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ExidynError, NotAFile
from ..preparation.prepare import Filtering
from ..robot_files.robot_file import model_text, parse_model
from .base_parameters import BaseParameters
from .estimators import Estimate
from .fit import Agreement, Fit, Scores, Unclear
from .json_file import read_json

FORMAT = 1
"""Goes up when a reader of the former version would misunderstand a file."""
SCORES = ("relative", "r_squared", "residual_rms", "noise", "over_noise")
"""What is kept of the agreement with each run, a number a joint."""


def write_fit(fit: Fit, path: Path | str) -> None:
    """Write fit.json; the file appears under its name only when it is whole."""
    part = Path(path).with_name(Path(path).name + ".part")
    part.write_text(fit_text(fit), encoding="utf-8")
    os.replace(part, path)


def fit_text(fit: Fit) -> str:
    """The text of fit.json, one line an entry so that two fits can be compared line by line."""
    entries = [f'"{key}": {_lines(value)}' for key, value in _table(fit).items()]
    return "{\n" + ",\n".join(entries) + "\n}\n"


def read_fit(path: Path | str) -> Fit:
    """Read fit.json.

    Raises:
        NotAFile: Missing, cut off, no fit, or of a later format.
    """
    table = read_json(Path(path))
    if not isinstance(table, dict) or "exidyn_fit" not in table:
        raise NotAFile(f"{path} is no fit of exidyn: it has no key 'exidyn_fit'")
    if table["exidyn_fit"] != FORMAT:
        raise NotAFile(f"{path} has format {table['exidyn_fit']}; this version reads {FORMAT}; update exidyn")
    try:
        return _fit(table)
    except KeyError as error:
        raise NotAFile(f"{path}: key {error} is missing") from error
    except ExidynError as error:
        raise NotAFile(f"{path}: {error}") from error
    except (TypeError, ValueError, IndexError, AttributeError, ArithmeticError) as error:
        raise NotAFile(f"{path} is damaged: {error}") from error


def _lines(value: Any) -> str:
    """JSON with one line an item for lists of lists and of tables."""
    if isinstance(value, list) and value and isinstance(value[0], list | dict):
        return "[\n" + ",\n".join(json.dumps(item, ensure_ascii=False) for item in value) + "\n]"
    return json.dumps(value, ensure_ascii=False)


def _numbers(array: np.ndarray) -> list:
    """Nested lists; infinity and NaN, which JSON does not have, as text."""
    if array.ndim > 1:
        return [_numbers(row) for row in array]
    return [float(v) if np.isfinite(v) else str(float(v)) for v in array]


def _array(values: Sequence) -> np.ndarray:
    """Inverse of `_numbers`; numbers as text are converted one by one to keep every digit."""
    if values and isinstance(values[0], list):
        return np.array([_array(row) for row in values])
    return np.array([float(v) for v in values])


def _table(fit: Fit) -> dict[str, Any]:
    estimate = fit.estimate
    return {
        "exidyn_fit": FORMAT,
        "robot": fit.model.robot.name,
        "joints": list(fit.model.robot.joints),
        "method": estimate.method,
        "runs": list(fit.runs),
        "measures": fit.measures,
        "rows": fit.rows,
        "condition": fit.condition,
        "filtering": asdict(fit.filtering),
        "drive_gain": _numbers(estimate.gain),
        "drive_gain_std": _numbers(estimate.gain_std),
        "noise": _numbers(estimate.noise),
        "noise_floor": None if fit.noise is None else _numbers(fit.noise),
        "noise_floor_from": fit.noise_source,
        "carried": dict(fit.carried),
        "simulations": list(fit.simulations),
        "base_parameters": _base_parameters(fit),
        "dropped": list(fit.dropped),
        "moved": [one.name for one in fit.moved],
        "gap": [float(share) for share in fit.base.gap],
        "covariance": _numbers(estimate.covariance),
        "standard_parameters": None if estimate.standard is None else _numbers(estimate.standard),
        "unclear": [asdict(u) for u in fit.unclear],
        "warnings": list(fit.warnings),
        "agreement": [_scores(a) for a in fit.agreement],
        "validation": [_scores(a) for a in fit.validation],
        "model": model_text(fit.model).split("\n"),
    }


def _base_parameters(fit: Fit) -> list[dict[str, Any]]:
    """A table a base parameter; those that were dropped have the value that they had."""
    structure, places = fit.structure or fit.base, {name: row for row, name in enumerate(fit.names)}
    std, taken, (nominal, tolerance) = fit.estimate.std, fit.exported, fit.prior
    tables = []
    for row, (name, unit) in enumerate(zip(structure.names, structure.units, strict=True)):
        place = places.get(name)
        kept = place is not None
        tables.append(
            {
                "name": name,
                "unit": unit,
                "kept": kept,
                "value": float(fit.estimate.values[place]) if kept else fit.dropped[name],
                **({"std": float(std[place])} if kept else {}),
                **({"exported": float(taken[place])} if kept and taken is not None else {}),
                **({"prior": _numbers(np.array([nominal[place], tolerance[place]]))} if kept else {}),
                "column": int(structure.kept[row]),
                "sum_of": _weights(structure, row),
            }
        )
    return tables


def _weights(base: BaseParameters, row: int) -> dict[str, float]:
    """Standard parameters in a base parameter, with their weights."""
    return {
        base.parameters[c].name: float(base.regrouping[row, c]) for c in np.flatnonzero(base.regrouping[row])
    }


def _scores(agreement: Agreement) -> dict[str, Any]:
    numbers = {name: _numbers(getattr(agreement, name)) for name in SCORES}
    return {"run": agreement.run, "noise_source": agreement.noise_source} | numbers


def _read_scores(table: dict[str, Any]) -> tuple[Scores, ...]:
    """Those of runs used, then those of runs held out."""
    return tuple(
        Scores(
            run=one["run"],
            held_out=key == "validation",
            noise_source=one.get("noise_source", ""),
            **{name: _array(one[name]) for name in SCORES},
        )
        for key in ("agreement", "validation")
        for one in table.get(key, ())
    )


def _fit(table: dict[str, Any]) -> Fit:
    model = parse_model("\n".join(table["model"]))
    rows = table["base_parameters"]
    kept = [row for row in rows if row["kept"]]
    values = {row["name"]: row["value"] for row in rows}
    parameters, gap = tuple(model.parameters), tuple(table["gap"])
    standard, scores = table["standard_parameters"], _read_scores(table)
    # Older files call the prior "believed" and the warnings "doubts".
    prior = _array([row["prior"] if "prior" in row else row["believed"] for row in kept])
    return Fit(
        model=model,
        base=_base(parameters, kept, gap),
        estimate=Estimate(
            method=table["method"],
            values=_array([row["value"] for row in kept]),
            gain=_array(table["drive_gain"]),
            covariance=_array(table["covariance"]),
            noise=_array(table["noise"]),
            standard=None if standard is None else _array(standard),
        ),
        runs=tuple(table["runs"]),
        filtering=Filtering(**table["filtering"]),
        condition=float(table["condition"]),
        rows=int(table["rows"]),
        prior=(prior[:, 0], prior[:, 1]),
        dropped={name: values[name] for name in table["dropped"]},
        unclear=tuple(Unclear(**unclear) for unclear in table["unclear"]),
        warnings=tuple(table["warnings"] if "warnings" in table else table["doubts"]),
        structure=_base(parameters, rows, gap) if len(kept) < len(rows) else None,
        # Files of before the key: of torque all gains are 1, and of currents hardly ever.
        measures=table.get("measures", "torque" if _all_ones(table["drive_gain"]) else "current"),
        scores=scores,
        noise=_noise_floor(table, scores),
        noise_source=table.get("noise_floor_from", scores[0].noise_source if scores else ""),
        carried={str(run): str(body) for run, body in table.get("carried", {}).items()},
        simulations=tuple(table.get("simulations", ())),
        exported=_exported(kept),
    )


def _exported(kept: Sequence[dict[str, Any]]) -> np.ndarray | None:
    """None where there are none, or in files of before the key."""
    return _array([row["exported"] for row in kept]) if all("exported" in row for row in kept) else None


def _noise_floor(table: dict[str, Any], scores: Sequence[Scores]) -> np.ndarray | None:
    """The noise level; files of before the key have it as torque, beside each run."""
    if table.get("noise_floor") is not None:
        return _array(table["noise_floor"])
    return scores[0].noise / np.abs(_array(table["drive_gain"])) if scores else None


def _all_ones(gains: Sequence) -> bool:
    return all(float(gain) == 1.0 for gain in gains)


def _base(parameters: tuple, rows: Sequence[dict[str, Any]], gap: tuple) -> BaseParameters:
    columns = {parameter.name: column for column, parameter in enumerate(parameters)}
    regrouping = np.zeros((len(rows), len(parameters)))
    for row, table in enumerate(rows):
        for name, weight in table["sum_of"].items():
            regrouping[row, columns[name]] = weight
    return BaseParameters(parameters, np.array([row["column"] for row in rows]), regrouping, gap)
