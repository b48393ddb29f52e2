"""Files with results: fits, diagnoses with the samples beside them, comparisons, by what each says it is."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.consistency import check_diagnosis
from exidyn.identification.diagnosis.findings.evidence import Evidence, Trace
from exidyn.identification.diagnosis.findings.finding import Hypothesis
from exidyn.identification.diagnosis.improved.improved import FOUND, found_model, left_out, rivals
from exidyn.identification.diagnosis.words.diagnosis_file import FORMAT as DIAGNOSIS_FORMAT
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.document.html import html
from exidyn.identification.errors import ExidynError, NotAFile
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, read_json, read_table, write_fit
from exidyn.identification.model import Model
from exidyn.identification.pages.compared_document import verdict
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown
from exidyn.identification.recordings.reading_limits import require_zip
from exidyn.identification.result_file import from_table, to_table
from exidyn.identification.robot_files.effect_rows import FindingRow, findings_text
from exidyn.identification.robot_files.robot_file import model_text, parse_model
from exidyn.identification.schema import Disagreement, check
from exidyn.identification.simulation.comparison import Comparison

from ..terminal.json_output import json_text

FORMAT = 1
"""Format number of the JSON file of a comparison."""
NAME = "traces.npz"
"""File of the samples, beside diagnosis.json."""
WORDS = ("name", "role")
EXACT = ("time",)
"""What single precision would round: it keeps a torque to a ten-millionth, and a nanosecond of nothing."""


def read_shown(path: Path) -> Shown:
    """A diagnosis, with the samples beside it if there are any.

    Raises:
        NotAFile: If it is damaged or of another format, or the samples are cut off, of another kind,
            inconsistent, or of another diagnosis.
    """
    diagnosis, folder, samples = read_diagnosis(path), str(path.parent), path.with_name(NAME)
    if not samples.exists():
        return Shown(diagnosis, folder=folder)
    shown = _read_samples(samples, Shown(diagnosis, folder=folder))
    others = shown.model is not None and shown.model.robot.joints != diagnosis.joints
    findings = len(diagnosis.all_findings)
    if others or any(len(trace.explained) != findings for trace in shown.traces):
        raise NotAFile(f"{samples} belongs to another diagnosis than {path}; diagnose again")
    return shown


def read_diagnosis(path: Path) -> Diagnosis:
    """All of a diagnosis but its samples.

    Raises:
        NotAFile: If it is of another format, or a field is invalid; the message names the field.
    """
    table = read_table(path, "exidyn_diagnosis", DIAGNOSIS_FORMAT, "diagnose RUN")
    diagnosis = from_table(table, Diagnosis, str(path))
    try:
        check_diagnosis(diagnosis)
    except Disagreement as error:
        raise NotAFile(f"{path}: {error}") from None
    return diagnosis


def read_result(path: Path) -> Fit | Diagnosis | Comparison:
    """A fit, a diagnosis or a comparison, by what the file says it is.

    Raises:
        NotAFile: It is none of them, of another format, or damaged.
    """
    readers: dict[str, Callable[[Path], Fit | Diagnosis | Comparison]] = {
        "exidyn_fit": read_fit,
        "exidyn_diagnosis": read_diagnosis,
        "exidyn_comparison": read_comparison,
    }
    table = read_json(path)
    for key, reader in readers.items():
        if key in table:
            return reader(path)
    raise NotAFile(f"{path} is no fit, diagnosis or comparison of exidyn")


def comparison_table(comparison: Comparison, next_commands: list[str]) -> dict[str, Any]:
    """A comparison, its verdict and the commands that follow from it, for JSON."""
    words = {"verdict": verdict(comparison), "go_on": next_commands}
    return {"exidyn_comparison": FORMAT} | to_table(comparison) | words


def read_comparison(path: Path) -> Comparison:
    """A comparison.

    Raises:
        NotAFile: If it is damaged or of another format.
    """
    table = read_table(path, "exidyn_comparison", FORMAT, "simulate SIM --against RUN")
    return from_table(table, Comparison, str(path))


def write_diagnosis(diagnosis: Diagnosis, fit: Fit | None, folder: Path) -> list[Path]:
    """Write diagnosis.json, report.html, traces, models of findings and rivals, fit.json; return paths."""
    folder.mkdir(parents=True, exist_ok=True)
    shown = Shown.of(diagnosis, str(folder))
    texts = {
        "diagnosis.json": json_text(as_json(shown.diagnosis, str(folder))),
        "report.html": html(diagnosis_document(shown)),
    }
    if (model := found_model(diagnosis)) is not None:
        absent = left_out(diagnosis)
        rows = [
            _finding_row(diagnosis, finding, place not in absent)
            for place, finding in enumerate(diagnosis.all_findings)
        ]
        texts[FOUND] = _model_file(model, rows)
        for rival in rivals(diagnosis):
            other = diagnosis.all_findings[rival.finding].alternatives[rival.alternative]
            texts[rival.file] = _model_file(rival.model, [_finding_row(diagnosis, other, rival.held)])
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    if diagnosis.evidence is not None:
        write_traces(diagnosis.evidence, folder / NAME)
    if fit is not None:
        write_fit(fit, folder / "fit.json")
    optional_files = {NAME: diagnosis.evidence, "fit.json": fit}
    written = [name for name, content in optional_files.items() if content is not None]
    return [folder / name for name in (*texts, *written)]


def _finding_row(diagnosis: Diagnosis, hypothesis: Hypothesis, in_model: bool) -> FindingRow:
    joints = tuple(diagnosis.joints[joint] for joint in hypothesis.joints)
    return FindingRow(hypothesis.effect, joints, hypothesis.probability, in_model)


def _model_file(model: Model, rows: Sequence[FindingRow]) -> str:
    """A robot.toml with the findings that led to it."""
    return "\n".join(filter(None, (model_text(model), findings_text(rows))))


def write_traces(evidence: Evidence, path: Path) -> None:
    """Write the samples of a diagnosis."""
    arrays: dict[str, Any] = {"model": np.array(model_text(evidence.model)), "noise": evidence.noise}
    for index, trace in enumerate(evidence.traces):
        arrays |= _arrays(trace, str(index))
    with open(path, "wb") as file:
        np.savez_compressed(file, **arrays)


def _read_samples(path: Path, shown: Shown) -> Shown:
    try:
        require_zip(path)
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            keys = {name.partition(".")[0] for name in file.files if "." in name}
            traces = tuple(Trace(**_values(file, str(index))) for index in range(len(keys)))
            model = parse_model(str(file["model"]))
            _check(traces, model.robot.dof)
            return shown._replace(traces=traces, model=model)
    except ExidynError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise many types
        raise NotAFile(f"{path} is not a file of traces, or was cut off: {error}") from error


def _check(traces: Sequence[Trace], joints: int) -> None:
    """Raise `Disagreement` for the first shape or time that is inconsistent with the number of joints."""
    for key, run in enumerate(traces):
        time, rows = run.time, len(run.time)
        check(time.ndim == 1 and rows >= 2, f"run {key}: time", time.shape, "at least two times")
        increases = bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0))
        check(increases, f"run {key}: time", "others", "increasing times")
        shapes = {"time": (rows,), "explained": (len(run.explained), rows, joints)}
        for name in (field.name for field in fields(run) if field.name not in WORDS):
            values, shape = getattr(run, name), shapes.get(name, (rows, joints))
            check(values.shape == shape, f"run {key}: {name}", values.shape, f"numbers of shape {shape}")


def _arrays(run: Trace, key: str) -> dict[str, np.ndarray]:
    """Arrays of all fields; numbers outside `EXACT` are in single precision."""
    values = {field.name: np.asarray(getattr(run, field.name)) for field in fields(run)}
    exact = (*WORDS, *EXACT)
    return {f"{key}.{n}": v if n in exact else v.astype(np.float32) for n, v in values.items()}


def _values(file: np.lib.npyio.NpzFile, key: str) -> dict[str, Any]:
    values = {field.name: file[f"{key}.{field.name}"] for field in fields(Trace)}
    return {name: str(v) if name in WORDS else v.astype(float) for name, v in values.items()}
