"""exidyn study: record run after run, each chosen by what is still open, until the model is decided."""

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
from ..arguments.options import AS_RECORDED, BODY, JSON, make_folder, output_option
from ..arguments.run_options import DRIVING, STOPS, payload_of, require_mock
from ..files.given_runs import Case
from ..run.errors import RunStopped, Unsafe
from ..study.choice_file import ENDED, RoundChoice
from ..study.loop import Study
from ..study.rounds import NOTEBOOK, forget_end, require_same_robot
from ..study.sources import Cell, Shelf, Source
from ..terminal.json_output import hand_over, hide_file_names, json_text
from ..terminal.stopwatch import Stopwatch
from .diagnose_command import QUICK, diagnose_case, diagnose_command
from .excite_command import LIMITS, excite_command, wishes_of
from .identify_command import identify_command
from .record_command import record_command


@Command(
    "Plan, record, identify and diagnose run after run, each chosen to reduce the most\n"
    "uncertainty per second, until the model is decided, undecidable, or time is up.",
    (
        "exidyn study robot.toml --controller cell.toml --minutes 30",
        "exidyn study robot.toml --controller cell.toml --minutes 30 --mass 5 --com 0 0 0.04",
        "exidyn study robot.toml --plant truth.toml            # a simulated arm",
        "exidyn study robot.toml --from recordings             # choose among existing recordings",
    ),
    (
        Option("robot ROBOT", f"robot.toml, {NAMED}, or a built-in name"),
        Option("--minutes MIN", "largest total duration of the motions", positive, 30.0),
        Option("--from FOLDER", "use these recordings instead of a controller", Path, dest="recordings"),
        output_option("FOLDER", Path("exidyn-study")),
        AS_RECORDED,
        JSON,
        Group(
            "motions",
            (
                Option("--length S", "duration of an optimized trajectory", positive, 10.0),
                Option("--start Q...", "pose at start and end of each motion, n values [rad]", any_number),
                Option("--search S", "search time of a trajectory", positive, 5.0),
            ),
        ),
        Group("limits in addition to those of the robot", LIMITS),
        Group("controller", DRIVING),
        Group("limits that stop a run", STOPS),
        Group("available payload, to be mounted on the flange when requested", BODY),
    ),
    """Every finished step is stored in the folder: after a stop, the same command
continues.""",
)
def study_command(args: Namespace) -> None:
    """Run the study until the model is decided, undecidable or time is up; print the result."""
    make_folder(args.output)
    model = read_model(args.robot)
    request = {"minutes": args.minutes, "mass": args.mass, "recordings": str(args.recordings or "")}
    request["as_recorded"] = bool(args.as_recorded)
    require_same_robot(args.output, model)
    forget_end(args.output, request)
    source = _source(args, model)
    identify = partial(identify_step, as_recorded=args.as_recorded)
    diagnose = partial(diagnose_step, as_recorded=args.as_recorded)
    study = Study(args.output, model, source, 60.0 * args.minutes, identify, diagnose, request)
    with _interrupts_end():
        choice = study.run()
    hand_over(_page(choice, args.output), json_text(choice.table), args.json)


@contextmanager
def _interrupts_end() -> Iterator[None]:
    """Let Ctrl-C end the study even in a search, which would otherwise only end the search."""

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _page(choice: RoundChoice, folder: Path) -> str:
    lines = [ENDED[choice.verdict], *choice.believed, *choice.remains]
    lines += [f"{choice.moved / 60.0:.1f} min of motion; {folder / NOTEBOOK} describes each run"]
    return "\n".join(line for words in lines for line in paragraph(words))


def _source(args: Namespace, model: Model) -> Source:
    """The cell, or the existing recordings."""
    if args.recordings:
        if args.controller or args.driver or args.plant:
            raise ExidynError("--from uses existing recordings instead of a controller; omit one of them")
        return Shelf.of(args.recordings, model)
    name, settings = read_controller(args.controller, args.driver, args.set)
    require_mock(args, name)
    wishes = _wishes(args, model, settings)
    record = partial(_record, args)
    motions = args.output / "offers"
    return Cell(model, record, wishes, args.search, payload_of(args), name != "mock", motions)


def _wishes(args: Namespace, model: Model, settings: Mapping[str, Any]) -> Wishes:
    """Planning options of `exidyn excite` with the limits of the study."""
    excite_args = excite_command.parser().parse_args([args.robot, "--length", str(args.length)])
    for name in LIMITING:
        setattr(excite_args, name, getattr(args, name))
    excite_args.tick = float(settings.get("cycle", excite_args.tick))
    return wishes_of(excite_args, model, Stopwatch())


LIMITING = (
    "margin", "sure", "window", "start", "cell", "degrees", "collision_distance", "no_collision",
    "packages",
)  # fmt: skip
"""Options that a study passes on to `exidyn excite`."""


def identify_step(runs: Sequence[Path], folder: Path, as_recorded: bool = False) -> None:
    """Fit the runs like `exidyn identify`."""
    options = ["--as-recorded"] if as_recorded else []
    with _page_into(folder / SUMMARY):
        identify_command.main([*map(str, runs), "--output", str(folder), *options])


def diagnose_step(case: Case, folder: Path, as_recorded: bool = False) -> Diagnosed:
    """Diagnose a case like `exidyn diagnose --quick`."""
    options = ["--as-recorded"] if as_recorded else []
    args = diagnose_command.parser().parse_args([case.name, "--quick", *options])
    with _page_into(folder / SUMMARY), Stopwatch(QUICK) as progress:
        return diagnose_case(case, folder, args, progress)


def _record(args: Namespace, plan: Path, path: Path, body: KnownPayload | None) -> None:
    """Record a run like `exidyn record`, with its confirmation."""
    record_args = record_command.parser().parse_args([str(plan), "--robot", args.robot, "--approach"])
    record_args.output, record_args.name = path, path.parent.name
    for name in RECORDED if body is not None else RECORDED - {"mass", "com", "inertia"}:
        setattr(record_args, name, getattr(args, name))
    with _page_into(path.with_suffix(".txt")):
        code = record_command.run(record_args)
    if code == UNSAFE:
        raise Unsafe(f"{read_recording(path).outcome['standstill']}. The recording is in {path}")
    if code != DONE:
        raise RunStopped(
            f"the run of {path.parent.name} was stopped before its end; the recording is in {path}. The same "
            "command continues from here"
        )


@contextmanager
def _page_into(path: Path) -> Iterator[None]:
    """Redirect the page that a command prints into a file, since a study prints its own."""
    with path.open("w", encoding="utf-8") as file, redirect_stdout(file), hide_file_names():
        yield


SUMMARY = "summary.txt"
"""File of the page that a single command would print."""
RECORDED = {
    "driver", "controller", "set", "plant", "seed", "yes", "tracking", "current", "temperature",
    "mass", "com", "inertia", "no_collision", "packages", "cell",
}  # fmt: skip
"""Options that a study passes on to `exidyn record`."""
