"""The files of a diagnosis: tables, pages, models to distinguish, and answers of many cases."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from exidyn.identify.diagnosis import Diagnosis
from exidyn.identify.diagnosis.improved.forward import Forward
from exidyn.identify.diagnosis.improved.improved import FOUND, found_model, left_out, rivals
from exidyn.identify.diagnosis.words.diagnosis_file import answer, as_json, diagnosis_file
from exidyn.identify.diagnosis.words.naming import effect_words
from exidyn.identify.errors import NotAFile
from exidyn.identify.fit.fit import Fit
from exidyn.identify.fit.fit_file import read_json, write_fit
from exidyn.identify.model import Model
from exidyn.identify.pages.diagnosis_document import report_html
from exidyn.identify.robot_files.robot_text import model_text

from ..terminal.json_output import json_text, write_whole
from .traces_file import NAME, write_traces


def write_diagnosis(
    diagnosis: Diagnosis, simulated: Forward | None, fit: Fit | None, folder: Path
) -> list[Path]:
    """Write diagnosis.json, report.html, traces, models of findings and rivals, and fit.json; name them."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {
        "diagnosis.json": json_text(as_json(diagnosis_file(diagnosis, simulated, str(folder)))),
        "report.html": report_html(diagnosis, simulated, str(folder)),
    }
    if (model := found_model(diagnosis)) is not None:
        texts[FOUND] = _model_file(model, left_out(diagnosis))
        texts |= {one.file: _model_file(one.model, one.left_out) for one in rivals(diagnosis)}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    if diagnosis.evidence is not None:
        write_traces(diagnosis.evidence, folder / NAME, simulated)
    if fit is not None:
        write_fit(fit, folder / "fit.json")
    others = {NAME: diagnosis.evidence, "fit.json": fit}
    return [folder / name for name in (*texts, *(name for name, one in others.items() if one is not None))]


def _model_file(model: Model, absent: Sequence[str]) -> str:
    """A robot.toml that first lists the findings that it does not hold."""
    lacking = ", ".join(effect_words(one) for one in absent)
    head = f"# Found, and no part of this model, which cannot hold it: {lacking}.\n" if absent else ""
    return head + model_text(model)


def read_answers(path: Path) -> dict[str, Any]:
    """The answers that a file has already; none if there is no file.

    Raises:
        NotAFile: It is something else.
    """
    if not path.exists():
        return {}
    try:
        answers = read_json(path)
    except NotAFile as error:
        raise NotAFile(f"--answer exists, and {error}") from error
    if not isinstance(answers, dict):
        raise NotAFile(f"--answer {path} exists and is no table of cases")
    return answers


def add_answer(diagnosis: Diagnosis, path: Path) -> None:
    """Put a case's answer beside those of other cases; the file is never half written."""
    answers = read_answers(path) | {diagnosis.name: answer(diagnosis)}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json_text(answers))
