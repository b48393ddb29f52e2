"""Example: a spring balancer that the nominal model lacks, from the first motion to other simulators."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.candidates.springs import LEVERS, PRELOAD, STIFFNESS
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.fit.verdict import NORMAL_95
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import WIDTH, at_point, digits, paragraph, percent, table

from .example_arm import CENTRE, INERTIA, LEAST, MASS, NOMINAL, ExampleArm, Step, excited, recorded, step
from .example_result import EFFECT, IMPROVED, Result, Spring

COLUMNS = {
    "nominal": "nominal",
    "identified": "identified without",
    "found": "with it",
    "simulated before": "simulated without",
    "simulated after": "simulated with it",
}
"""What is left -> head of its column."""


def arm() -> ExampleArm:
    """The KR270, and one whose spring balancer is not stated."""
    truth = read_model("kr270")
    others = tuple(effect for effect in truth.effects if not isinstance(effect, SpringBalancer))
    names = replace(truth, effects=others, stated={}).names
    stated = {name: prior for name, prior in truth.stated.items() if name in names}
    return ExampleArm(truth, replace(truth, effects=others, stated=stated))


def steps(folder: Path, length: float, search: float) -> list[Step]:
    """Excite, record, identify, diagnose, model, simulate before and after, compare, export.

    Alone the arm can go wherever the balancer pulls, and with the payload it cannot; a payload that is known
    whole weighs the arm's own masses, which otherwise look like a spring.
    """
    body = "--mass", MASS, "--com", *CENTRE
    least = min(search, LEAST)
    runs = folder / "unloaded.mcap", "--payload", folder / "loaded.mcap", "--validate", folder / "other.mcap"
    return [
        excited(folder, "trajectory", length, search),
        excited(folder, "loaded", length, least, *body),
        excited(folder, "other", length, least, "--seed", "7"),
        recorded(folder, "unloaded", "trajectory", 1),
        recorded(folder, "loaded", "loaded", 2, *body, "--inertia", *INERTIA),
        recorded(folder, "other", "other", 3),
        step("identify", *runs, "--output", folder / "exidyn-fit"),
        step("diagnose", folder / NOMINAL, *runs, "--output", folder / "exidyn-diagnosis"),
        _export(folder / "exidyn-diagnosis" / "fit.json", "toml", folder / IMPROVED),
        *_simulated(folder, folder / "exidyn-fit" / "fit.json", "before"),
        *_simulated(folder, folder / IMPROVED, "after"),
        _export(folder / IMPROVED, "mjcf", folder / "kr270.xml"),
        _export(folder / IMPROVED, "urdf", folder / "kr270.urdf"),
    ]


def _export(model: Path, form: str, output: Path) -> Step:
    return step("export", model, "--to", form, "--output", output)


def _simulated(folder: Path, model: Path, when: str) -> list[Step]:
    """Simulate the motion held out, and compare with its recording."""
    made = folder / f"sim-{when}.mcap"
    return [
        step("simulate", model, folder / "other.toml", "--output", made),
        step("compare", made, folder / "other.mcap", "--json", folder / f"compare-{when}.json"),
    ]


def outcome(folder: Path) -> str:
    """What was concealed, what was named, and what that gained."""
    return words(Result.read(folder))


def words(result: Result) -> str:
    """One page."""
    parts = [
        ["A concealed balancer, and what was found in the recordings".center(WIDTH).rstrip(), "=" * WIDTH],
        [
            *paragraph(_concealed(result), " " * 11, "concealed: "),
            *paragraph(_named(result), " " * 11, "named:     "),
        ],
        ["The spring", "-" * WIDTH, *_spring(result)],
        ["What is left of a run held out, over noise: 1 is noise alone", "-" * WIDTH, *_left(result)],
        ["Where to look", "-" * WIDTH, *_files(result)],
    ]
    return (
        "\n".join(parts[0]) + "\n" + "\n\n".join("\n".join(part) for part in parts[1:]) + "\n" + "=" * WIDTH
    )


def _concealed(result: Result) -> str:
    return f"{EFFECT} of joint {result.joint + 1}; the model that was diagnosed has none"


def _named(result: Result) -> str:
    """Whether it was, and what else was."""
    if result.right is None:
        return f"NOT {EFFECT} of joint {result.joint + 1}. Named instead: {_list(result.wrong) or 'nothing'}"
    chance = result.right["probability"]
    sure = percent(chance, 3)
    text = f"{_list([result.right])}, probability {sure}: right"
    return f"{text}. Named as well, which is WRONG: {_list(result.wrong)}" if result.wrong else text


def _list(findings: Sequence[dict[str, Any]]) -> str:
    return ", ".join(
        f"{one['effect']} of {'joint ' + ', '.join(map(str, one['joints'])) if one['joints'] else 'the arm'}"
        for one in findings
    )


def _spring(result: Result) -> list[str]:
    """True coefficients beside those found, and how far the torques are apart at most."""
    true, found = result.concealed, result.found
    if found is None or result.right is None:
        return ["It was not found, so there is nothing to compare."]
    known, scale = result.right["parameters"], found.effect.d21 / true.effect.d21
    alike, drawn = found.as_long_as(true), true.in_place_of(found, result.robot)
    half = {name: NORMAL_95 * known[name]["std"] for name in (STIFFNESS, PRELOAD, LEVERS, "phi")}
    ratio = [spring.effect.d22 / spring.effect.d21 for spring in (true, found)]
    rows = [
        ("K_r", "N/m", true.stiffness, alike.stiffness, half[STIFFNESS] * scale**2, drawn.stiffness),
        ("K_0", "N", true.preload, alike.preload, half[PRELOAD] * scale, drawn.preload),
        ("d22/d21", "", *ratio, half[LEVERS] / found.effect.d21, np.nan),
        ("phi", "rad", true.effect.phi, found.effect.phi, half["phi"], np.nan),
    ]
    numbers = np.array([row[2:] for row in rows]).T
    true_values, named, _, by_drawing = numbers
    cells = [[digits(value) for value in column] for column in numbers]
    off = [[_percent(value) for value in 100 * (one / true_values - 1)] for one in (named, by_drawing)]
    columns = [[row[0] for row in rows], [row[1] for row in rows], *map(at_point, (*cells[:3], off[0]))]
    columns += map(at_point, (cells[3], off[1]))
    head = ["", "unit", "true", "named", "± 95 %", "off %", "on the drawing", "off %"]
    lines = table(head, [list(row) for row in zip(*columns, strict=True)], left=(0, 1))
    return [*lines, *paragraph(_torque_words(result, found))]


def _torque_words(result: Result, found: Spring) -> str:
    """How to read the table, and how well the torque is found."""
    real = result.concealed.torque(result.robot)
    off = float(np.max(np.abs(found.torque(result.robot) - real)))
    most = float(np.max(np.abs(real)))
    return (
        "Torque shows a spring's lengths up to scale, and hardly their ratio: K_r and K_0 are for the true "
        "d21. On the drawing: the torque that was found, put to the true lengths and "
        f"angle. Over the joint's range that torque is right to {digits(off)} N m of {digits(most)}, "
        f"{percent(off / most)}."
    )


def _percent(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "-"


def _left(result: Result) -> list[str]:
    columns = [at_point([digits(value) for value in result.left[name]]) for name in COLUMNS]
    rows = [list(row) for row in zip(result.robot.joints, *columns, strict=True)]
    return table(["joint", *COLUMNS.values()], rows)


def _files(result: Result) -> list[str]:
    """What to open, and with what."""
    diagnosis = result.folder / "exidyn-diagnosis"
    rows = [
        [str(diagnosis / "report.html"), "the diagnosis, in a browser"],
        [str(result.folder / "exidyn-fit" / "report.html"), "what was identified without the spring"],
        [str(result.folder / IMPROVED), "the model with it; kr270.xml, kr270.urdf"],
        [f"exidyn view {diagnosis / 'diagnosis.json'}", "all of it over time, the arm moving"],
    ]
    return [line for place, what in rows for line in (place, f"    {what}")]
