"""Recordings of real arms with weighed payloads.

UR10e: the drive gains come from one payload, and the other one is identified; or only from published gains.
STS3215: a servo swings weighed masses at a known distance; the lightest is the empty arm. XL330: a servo with
one weighed mass and no empty arm, whose gain is known to 50 %. KR270: the payload of `exidyn example`, 175 kg
on a simulated arm whose stated drive gains are 10 % too large; its commands plan and record the runs, and the
payload is then weighed without its stated mass.
"""

import contextlib
import io
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.acquire.command_line import main
from exidyn.acquire.examples import example_runs
from exidyn.acquire.examples.example_runs import MASS
from exidyn.identification.effects import known_parameters
from exidyn.identification.effects.rigid_body import with_bodies
from exidyn.identification.fit.identification import identify
from exidyn.identification.payload.body import Body
from exidyn.identification.payload.payload_estimate import DESCRIPTION, DIFFERENCE, FIT, PayloadEstimate
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..real.data import FOLDER, LOADED, UR10E

QUICK_RUNS = 2
SERVO = "kscale_sts3215"
MOTIONS = ("sin_sin_kp16", "sin_time_square_kp16", "up_and_down_kp16")
EMPTY, KNOWN = "m535", ("m1168", 0.633)
"""Mass that counts as the empty servo, and the one that gives the gain, beyond it [kg]."""
UNKNOWN = {"m741": 0.206, "m969": 0.434}
XL330, XL330_RUNS = "bam_xl330", ("kp100_sin_sin", "kp200_sin_sin", "kp400_sin_sin")
XL330_MASS, XL330_CENTER, XL330_TOLERANCE = 0.49, (0.0, 0.0, -0.1), 0.5
"""Mass [kg], its center [m], and tolerance of the gain: two methods differ by a factor of two."""
LIGHT = 1e-3
"""Mass of a link that stands for none [kg]."""


def real_cases(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    """Name -> function that identifies a payload; empty without the recordings."""
    if not (FOLDER / UR10E.urdf).exists():
        return {}
    pairs = ((LOADED[0], LOADED[1]), (LOADED[1], LOADED[0]))
    cases: dict[str, Callable[[], dict[str, Any]]] = {}
    for unknown, known in pairs[: 1 if quick else None]:
        for way in (FIT, DIFFERENCE, DESCRIPTION):
            cases[f"UR10e, {unknown[1]:g} kg, {way}"] = lambda u=unknown, k=known, w=way: ur10e(
                u, k, w, quick
            )
    for body, mass in UNKNOWN.items():
        for way in (FIT, DIFFERENCE, DESCRIPTION):
            cases[f"STS3215, {mass:g} kg, {way}"] = lambda b=body, m=mass, w=way: servo(b, m, w)
    cases[f"XL330, {XL330_MASS:g} kg, {DESCRIPTION}"] = xl330
    return cases


def xl330() -> dict[str, Any]:
    """The mass of the XL330, from a description of an arm without mass."""
    model = read_model(FOLDER / XL330 / "robot.toml")
    bodies = np.array([ball(LIGHT, XL330_CENTER)])
    robot = replace(
        with_bodies(model.robot, bodies), drive_gain_tolerance=XL330_TOLERANCE, inertias_stated=True
    )
    bare = replace(model, robot=robot)
    runs = [import_source(FOLDER / XL330 / f"{name}.csv.gz", bare)[0] for name in XL330_RUNS]
    return score(weigh(runs, model=bare, com=XL330_CENTER, as_recorded=True), XL330_MASS)


def ball(mass: float, center: tuple[float, ...]) -> np.ndarray:
    """Ten parameters of a small ball."""
    return Body(mass, np.array(center), mass * 1e-4 * np.eye(3)).parameters


def ur10e(unknown: tuple[str, float], known: tuple[str, float], way: str, quick: bool) -> dict[str, Any]:
    """One payload of the UR10e."""
    model, filtering = UR10E.model(), UR10E.filtering
    empty = [UR10E.run(name) for name in UR10E.train[: QUICK_RUNS if quick else None]]
    loaded = UR10E.run(unknown[0])
    if way == FIT:
        weight = UR10E.run(known[0], KnownPayload("W", (("M", known[1]),)))
        fit = identify([*empty, weight], model=model, filtering=filtering, as_recorded=True)
        return score(weigh([loaded], fit=fit, as_recorded=True), unknown[1])
    runs = empty if way == DIFFERENCE else []
    result = weigh([loaded], empty=runs, model=model, filtering=filtering, as_recorded=True)
    return score(result, unknown[1])


def servo(body: str, mass: float, way: str) -> dict[str, Any]:
    """One mass of the servo, at a known distance."""
    model = read_model(FOLDER / SERVO / "robot.toml")

    def runs(name: str) -> list[Recording]:
        files = [FOLDER / SERVO / f"{name}_l100_{motion}.csv.gz" for motion in MOTIONS]
        return [replace(import_source(file, model)[0], payload=None) for file in files]

    empty, center = runs(EMPTY), (0.0, 0.0, 0.0)
    if way == FIT:
        weight = KnownPayload("W", known_parameters(KNOWN[1], center))
        weighed = [replace(run, payload=weight) for run in runs(KNOWN[0])]
        fit = identify([*empty, *weighed], model=model, as_recorded=True)
        return score(weigh(runs(body), fit=fit, com=center, as_recorded=True), mass)
    without = empty if way == DIFFERENCE else []
    return score(weigh(runs(body), empty=without, model=model, com=center, as_recorded=True), mass)


def score(result: PayloadEstimate, mass: float) -> dict[str, Any]:
    """Error and interval of the mass."""
    return {
        "true": mass,
        "found": result.mass.value,
        "low": result.mass.low,
        "high": result.mass.high,
        "error_percent": 100.0 * (result.mass.value / mass - 1.0),
        "holds": result.mass.holds(mass),
        "check": result.check.passed,
    }


SECONDS = 20.0
"""Duration of the motion: what the aim allows for weighing [s]."""
RECORDED = ("unloaded", "loaded")


@cache
def runs() -> tuple[Recording, Recording]:
    """The run without the payload, and the one with it, whose stated payload is removed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        example_runs.gains_arm().write(folder)
        for step in example_runs.gains_steps(folder, SECONDS, None):
            output = Path(step.arguments[step.arguments.index("--output") + 1])
            if output.stem in ("trajectory", *RECORDED):
                with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                    if code := main([step.command, *step.arguments]):
                        raise RuntimeError(f"{step}: exit code {code}")
        empty, loaded = (import_source(folder / f"{name}.mcap", None)[0] for name in RECORDED)
    return empty, replace(loaded, payload=None)


def example_cases() -> dict[str, Callable[[], dict[str, Any]]]:
    """Name -> function that identifies the payload."""
    return {
        f"KR270 example, {MASS:g} kg, {way}": lambda w=way: weighed(w)
        for way in (FIT, DIFFERENCE, DESCRIPTION)
    }


def weighed(way: str) -> dict[str, Any]:
    """The payload, by what is known of the arm."""
    empty, loaded = runs()
    if way == FIT:
        return score(weigh([loaded], fit=identify([empty])), MASS)
    return score(weigh([loaded], empty=[empty] if way == DIFFERENCE else []), MASS)
