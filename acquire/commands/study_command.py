"""exidyn study: run after run, each chosen by what the ones before left open, until the model is decided."""

import signal
from argparse import Namespace
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis.diagnose import Diagnosed
from exidyn.identification.errors import ExidynError
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.description import NAMED
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph
from exidyn.trajectories.planning.wishes import Wishes

from ..arguments.command import Command, Group, Option, any_number, positive
from ..arguments.controllers import read_controller
from ..arguments.exit_codes import DONE, UNSAFE
from ..arguments.options import AS_RECORDED, BODY, JSON, make_folder, output_option, require_json
from ..arguments.run_options import DRIVING, STOPS, body_of, require_mock
from ..files.given_runs import Case
from ..run.errors import RunStopped, Unsafe
from ..study.choice_file import ENDED
from ..study.loop import Study
from ..study.rounds import NOTEBOOK, forget_end, require_same_robot
from ..study.sources import Cell, Shelf, Source
from ..terminal.json_output import files_untold, hand_over, json_text
from ..terminal.stopwatch import Stopwatch
from .diagnose_command import QUICK, diagnose_case, diagnose_command
from .excite_command import LIMITS, excite_command, wishes_of
from .identify_command import identify_command
from .record_command import record_command


@Command(
    "Plan, record, identify, diagnose, and choose the run that settles most per second, until\n"
    "the model is decided, undecidable by any motion, or out of time.",
    (
        "exidyn study robot.toml --controller cell.toml --minutes 30",
        "exidyn study robot.toml --controller cell.toml --minutes 30 --mass 5 --com 0 0 0.04",
        "exidyn study robot.toml --plant truth.toml            # a simulated arm",
        "exidyn study robot.toml --from recordings             # the same choices among runs that exist",
    ),
    (
        Option("robot ROBOT", f"robot.toml, {NAMED}, or a name built in"),
        Option("--minutes MIN", "of motion at most", positive, 30.0),
        Option("--from FOLDER", "recordings, in place of a controller", Path, dest="recordings"),
        output_option("FOLDER", Path("exidyn-study")),
        AS_RECORDED,
        JSON,
        Group(
            "motions",
            (
                Option("--length S", "of one that is searched", positive, 10.0),
                Option("--start Q...", "pose where each begins and ends, n numbers [rad]", any_number),
                Option("--search S", "for it", positive, 5.0),
            ),
        ),
        Group("limits, beyond the robot's own", LIMITS),
        Group("controller", DRIVING),
        Group("what stops a run", STOPS),
        Group("a body that you have, to be hung on the flange when asked for", BODY),
    ),
    """The folder keeps every step that is done: the same command goes on where it was
stopped.""",
)
def study_command(given: Namespace) -> None:
    """Go on until the model is decided, undecidable or out of time; print what came of it."""
    require_json(given.json)
    make_folder(given.output)
    model = read_model(given.robot)
    asked = {"minutes": given.minutes, "mass": given.mass, "recordings": str(given.recordings or "")}
    asked["as_recorded"] = bool(given.as_recorded)
    require_same_robot(given.output, model)
    forget_end(given.output, asked)
    source = _source(given, model)
    identify = partial(identify_step, as_recorded=given.as_recorded)
    diagnose = partial(diagnose_step, as_recorded=given.as_recorded)
    study = Study(given.output, model, source, 60.0 * given.minutes, identify, diagnose, asked)
    with _interrupts_end():
        choice = study.run()
    hand_over(_page(choice, given.output), json_text(choice), given.json)


@contextmanager
def _interrupts_end() -> Iterator[None]:
    """Ctrl-C ends the study in a search too, which by itself would go on with the best motion so far."""

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _page(choice: dict[str, Any], folder: Path) -> str:
    lines = [ENDED[choice["verdict"]], *choice["believed"], *choice["remains"]]
    lines += [f"{choice['moved'] / 60.0:.1f} min of motion; an account of each run is in {folder / NOTEBOOK}"]
    return "\n".join(line for words in lines for line in paragraph(words))


def _source(given: Namespace, model: Model) -> Source:
    """The cell, or the recordings that exist."""
    if given.recordings:
        if given.controller or given.driver or given.plant:
            raise ExidynError("--from takes recordings that exist, and no controller; leave one of them out")
        return Shelf.of(given.recordings, model)
    name, settings = read_controller(given.controller, given.driver, given.set)
    require_mock(given, name)
    wishes = _wishes(given, model, settings)
    record = partial(_record, given)
    motions = given.output / "offers"
    return Cell(model, record, wishes, given.search, body_of(given), name != "mock", motions)


def _wishes(given: Namespace, model: Model, settings: Mapping[str, Any]) -> Wishes:
    """What `exidyn excite` keeps to with the same options, clear of collisions and regions."""
    asked = excite_command.parser().parse_args([given.robot, "--length", str(given.length)])
    for name in LIMITING:
        setattr(asked, name, getattr(given, name))
    asked.tick = float(settings.get("cycle", asked.tick))
    return wishes_of(asked, model, Stopwatch())


LIMITING = (
    "margin", "sure", "window", "start", "region", "degrees", "collision_distance", "no_collision",
    "packages",
)  # fmt: skip
"""What a study has in common with `exidyn excite`."""


def identify_step(runs: Sequence[Path], folder: Path, as_recorded: bool = False) -> None:
    """Fit, as `exidyn identify` does."""
    more = ["--as-recorded"] if as_recorded else []
    with _page_into(folder / SUMMARY):
        identify_command.main([*map(str, runs), "--output", str(folder), *more])


def diagnose_step(case: Case, folder: Path, as_recorded: bool = False) -> Diagnosed:
    """Diagnose, as `exidyn diagnose --quick` does."""
    more = ["--as-recorded"] if as_recorded else []
    given = diagnose_command.parser().parse_args([case.name, "--quick", *more])
    with _page_into(folder / SUMMARY), Stopwatch(QUICK) as progress:
        return diagnose_case(case, folder, given, progress)


def _record(given: Namespace, plan: Path, path: Path, body: KnownPayload | None) -> None:
    """Record, as `exidyn record` does, its question included."""
    asked = record_command.parser().parse_args([str(plan), "--robot", given.robot, "--approach"])
    asked.output, asked.name = path, path.parent.name
    for name in RECORDED if body is not None else RECORDED - {"mass", "com", "inertia"}:
        setattr(asked, name, getattr(given, name))
    with _page_into(path.with_suffix(".txt")):
        code = record_command.run(asked)
    if code == UNSAFE:
        raise Unsafe(f"{read_recording(path).outcome['standstill']}. What was recorded is in {path}")
    if code != DONE:
        raise RunStopped(
            f"the run of {path.parent.name} was stopped before its end; what was recorded is in {path}. The "
            "same command goes on from here"
        )


@contextmanager
def _page_into(path: Path) -> Iterator[None]:
    """What a command prints as its page goes into a file: a study has a page of its own."""
    with path.open("w", encoding="utf-8") as file, redirect_stdout(file), files_untold():
        yield


SUMMARY = "summary.txt"
"""What a single command would have printed."""
RECORDED = {
    "driver", "controller", "set", "plant", "seed", "yes", "tracking", "current", "temperature",
    "mass", "com", "inertia", "no_collision", "packages", "region",
}  # fmt: skip
"""Options of `exidyn record` that a study hands on."""
