"""Example: a spring balancer that the nominal model lacks, from the first motion to other simulators."""

from dataclasses import replace
from pathlib import Path

from exidyn.identify.effects import SpringBalancer
from exidyn.identify.robot_files.robot_file import read_model

from .example_arm import CENTRE, INERTIA, MASS, NOMINAL, ExampleArm
from .example_result import IMPROVED, Result
from .example_steps import LEAST, Step, excited, recorded, step
from .example_words import words


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
