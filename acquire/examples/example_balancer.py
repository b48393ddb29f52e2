"""Example: a spring balancer that the nominal model lacks, from the first motion to an export."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.candidates.springs import LEVERS, PRELOAD, STIFFNESS
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.fit.verdict import NORMAL_95
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import at_point, digits, page_width, paragraph, percent, table

from .example_arm import CENTER, INERTIA, MASS, NOMINAL, ExampleArm, Step, excited, recorded, step
from .example_result import EFFECT, IMPROVED, Result, Spring

COLUMNS = {
    "nominal": "nominal",
    "identified": "identified without",
    "found": "with it",
    "simulated before": "simulated without",
    "simulated after": "simulated with it",
}
"""Residual -> head of its column."""


def arm() -> ExampleArm:
    """The KR270, and its model without the spring balancer."""
    truth = read_model("kr270")
    others = tuple(effect for effect in truth.effects if not isinstance(effect, SpringBalancer))
    names = replace(truth, effects=others, stated={}).names
    stated = {name: prior for name, prior in truth.stated.items() if name in names}
    return ExampleArm(truth, replace(truth, effects=others, stated=stated))


def steps(folder: Path, length: float, search: float | None) -> list[Step]:
    """Excite, record, identify, diagnose, improve the model, simulate both models, compare, export.

    Only the unloaded arm reaches all positions in which the balancer pulls. The loaded run with a fully known
    payload determines the arm's own masses, which otherwise resemble a spring.
    """
    body = "--mass", MASS, "--com", *CENTER
    runs = folder / "unloaded.mcap", "--payload", folder / "loaded.mcap", "--validate", folder / "other.mcap"
    return [
        excited(folder, "trajectory", length, search),
        excited(folder, "loaded", length, search, *body, least=True),
        excited(folder, "other", length, search, "--seed", "7", least=True),
        recorded(folder, "unloaded", "trajectory", 1),
        recorded(folder, "loaded", "loaded", 2, *body, "--inertia", *INERTIA),
        recorded(folder, "other", "other", 3),
        step("identify", *runs, "--output", folder / "exidyn-fit"),
        step("diagnose", *runs, "--robot", folder / NOMINAL, "--output", folder / "exidyn-diagnosis"),
        _export(folder / "exidyn-diagnosis" / "fit.json", "toml", folder / IMPROVED),
        *_simulated(folder, folder / "exidyn-fit" / "fit.json", "before"),
        *_simulated(folder, folder / IMPROVED, "after"),
        _export(folder / IMPROVED, "mjcf", folder / "kr270.xml"),
        _export(folder / IMPROVED, "urdf", folder / "kr270.urdf"),
    ]


def _export(model: Path, form: str, output: Path) -> Step:
    return step("export", model, "--to", form, "--output", output)


def _simulated(folder: Path, model: Path, when: str) -> list[Step]:
    """Simulate the held-out motion, and compare it with its recording."""
    simulation, compared = folder / f"sim-{when}.mcap", folder / f"compare-{when}.json"
    return [
        step("simulate", model, folder / "other.toml", "--output", simulation),
        step("simulate", simulation, "--against", folder / "other.mcap", "--json", compared),
    ]


def outcome(folder: Path) -> str:
    """The concealed effect, the findings, and the residuals without and with them."""
    return words(Result.read(folder))


def words(result: Result) -> str:
    """The result as one page of text."""
    width = page_width.get()
    parts = [
        ["A concealed balancer, and the findings in the recordings".center(width).rstrip(), "=" * width],
        [
            *paragraph(_concealed(result), " " * 11, "concealed: "),
            *paragraph(_named(result), " " * 11, "named:     "),
        ],
        ["The spring", "-" * width, *_spring(result)],
        ["Residual of the held-out run over the noise floor", "-" * width, *_residuals(result)],
        ["Where to look", "-" * width, *_files(result)],
    ]
    return (
        "\n".join(parts[0]) + "\n" + "\n\n".join("\n".join(part) for part in parts[1:]) + "\n" + "=" * width
    )


def _concealed(result: Result) -> str:
    return f"{EFFECT} of joint {result.joint + 1}, which the diagnosed model lacks"


def _named(result: Result) -> str:
    """Whether the concealed effect was named, and which others."""
    if result.right is None:
        return f"NOT {EFFECT} of joint {result.joint + 1}. Named instead: {_list(result.wrong) or 'nothing'}"
    text = f"{_list([result.right])}, probability {percent(result.right['probability'], 3)}: right"
    return f"{text}. Also named, which is WRONG: {_list(result.wrong)}" if result.wrong else text


def _list(findings: Sequence[dict[str, Any]]) -> str:
    return ", ".join(
        f"{f['effect']} of {'joint ' + ', '.join(map(str, f['joints'])) if f['joints'] else 'the arm'}"
        for f in findings
    )


def _spring(result: Result) -> list[str]:
    """Table of true and estimated coefficients, and the largest difference of the torques."""
    true, estimate = result.concealed, result.estimate
    if estimate is None or result.right is None:
        return ["The spring was not found, so there is nothing to compare."]
    parameters, scale = result.right["parameters"], estimate.effect.d21 / true.effect.d21
    scaled, drawn = estimate.as_long_as(true), true.in_place_of(estimate, result.robot)
    half = {name: NORMAL_95 * parameters[name]["std"] for name in (STIFFNESS, PRELOAD, LEVERS, "phi")}
    ratio = [spring.effect.d22 / spring.effect.d21 for spring in (true, estimate)]
    rows = [
        ("K_r", "N/m", true.stiffness, scaled.stiffness, half[STIFFNESS] * scale**2, drawn.stiffness),
        ("K_0", "N", true.preload, scaled.preload, half[PRELOAD] * scale, drawn.preload),
        ("d22/d21", "", *ratio, half[LEVERS] / estimate.effect.d21, np.nan),
        ("phi", "rad", true.effect.phi, estimate.effect.phi, half["phi"], np.nan),
    ]
    numbers = np.array([row[2:] for row in rows]).T
    true_values, estimates, _, drawn_values = numbers
    cells = [[digits(value) for value in column] for column in numbers]
    errors = [
        [_percent(value) for value in 100 * (values / true_values - 1)]
        for values in (estimates, drawn_values)
    ]
    columns = [[row[0] for row in rows], [row[1] for row in rows], *map(at_point, (*cells[:3], errors[0]))]
    columns += map(at_point, (cells[3], errors[1]))
    head = ["", "unit", "true", "named", "± 95 %", "off %", "on the drawing", "off %"]
    lines = table(head, [list(row) for row in zip(*columns, strict=True)], left=(0, 1))
    return [*lines, *paragraph(_torque_words(result, estimate))]


def _torque_words(result: Result, estimate: Spring) -> str:
    """How to read the table, and the error of the estimated torque."""
    true = result.concealed.torque(result.robot)
    error = float(np.max(np.abs(estimate.torque(result.robot) - true)))
    largest = float(np.max(np.abs(true)))
    return (
        "Torque determines a spring's lengths up to scale, and barely their ratio: K_r and K_0 are for the "
        "true d21. On the drawing: the estimated torque with the true lengths and angle. Over the joint's "
        f"range the largest error of the torque is {digits(error)} N m of {digits(largest)} N m, "
        f"{percent(error / largest)}."
    )


def _percent(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "-"


def _residuals(result: Result) -> list[str]:
    columns = [at_point([digits(value) for value in result.residuals[name]]) for name in COLUMNS]
    rows = [list(row) for row in zip(result.robot.joints, *columns, strict=True)]
    return table(["joint", *COLUMNS.values()], rows)


def _files(result: Result) -> list[str]:
    """Files to open, and their contents."""
    diagnosis = result.folder / "exidyn-diagnosis"
    rows = [
        [str(diagnosis / "report.html"), "the diagnosis, in a browser"],
        [str(result.folder / "exidyn-fit" / "report.html"), "the fit without the spring"],
        [str(result.folder / IMPROVED), "the model with the spring; also kr270.xml, kr270.urdf"],
        [f"exidyn view {diagnosis / 'diagnosis.json'}", "the diagnosis over time, with the moving arm"],
    ]
    return [line for path, content in rows for line in (path, f"    {content}")]
