"""A run of an arm and who records and shows it, for every command that moves one."""

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from exidyn.drivers import Driver, Info, Sample
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload

from ..arguments.exit_codes import DONE, STOPPED, UNSAFE
from ..arguments.parser import complaint
from ..run.announcer import BLOCKED, Announcer
from ..run.errors import print_line
from ..run.frames import END, text_frame
from ..run.perform import Job, Outcome, perform
from ..run.pipe import PipeSink, Sink
from ..run.realtime import realtime
from ..run.recorder import RunHead, part_of, start_recorder
from ..run.stopping.standstill import unknown_at_end
from ..run.stopping.stop import StopRequests
from ..terminal import run_summary
from ..terminal.json_output import print_written

BLOCKED_LOOP = f"the driver or this computer has been blocked for {BLOCKED:g} s"
"""What is not known then, while it lasts."""


def free_path(wanted: Path | None, stem: str) -> Path:
    """Where to write; without a wish the first of stem.mcap, stem-2.mcap, ... that is not there yet."""
    names = (Path(f"{stem}-{number}.mcap" if number > 1 else f"{stem}.mcap") for number in range(1, 100_000))
    return wanted or next(p for p in names if not p.exists() and not part_of(p).exists())


def run_head(
    info: Info,
    name: str,
    model: Model,
    driver: str,
    payload: KnownPayload | None,
    trajectory: str = "",
    **more: str,
) -> Callable[[Sample], bytes]:
    """What explains a run in its recording, ready but for the time of its first sample.

    Args:
        info: Metadata of the driver.
        name: Name of the run.
        model: The nominal arm, without what it carries.
        driver: Name of the driver.
        payload: What the arm carries.
        trajectory: Text of the plan's file.
        more: What else is known of the run, by name; what is empty is left out.
    """
    settings = {
        "driver": driver,
        "cycle": f"{info.cycle:g} s",
        "clock": info.clock,
        "dead man": info.dead_man or "none",
        "recorded": datetime.now(UTC).isoformat(timespec="seconds"),
        "exidyn": version("exidyn"),
        **more,
        **{f"driver {name}": text for name, text in info.settings.items()},
    }
    begun = RunHead(
        name=name,
        model=model,
        signals=info.signals,
        trajectory=trajectory,
        payload=payload,
        settings={name: text for name, text in settings.items() if text},
        warnings=info.warnings,
        state=info.state,
    ).prepare_frame()
    return lambda sample: begun(sample.host_time, sample.controller_time)


def run_recorded(
    driver: Driver,
    job: Job | Callable[[Info], Job],
    path: Path,
    head: Callable[[Info], Callable[[Sample], bytes]],
    viewers: Callable[[], Iterable[PipeSink]] = tuple,
    also: Sequence[Sink] = (),
) -> tuple[Outcome, PipeSink]:
    """Start who records and shows, run, and see it written.

    Args:
        driver: Not open yet.
        job: What to do, see `perform`.
        path: Where to record.
        head: What explains the run to them.
        viewers: Starts who else is to see it.
        also: Who else is handed every cycle, in this process.

    Returns:
        How the run went, and the recorder, which has ended.
    """
    with ExitStack() as stack:
        # First in, last out: what is asked while the recorder finishes must not end it.
        asked = stack.enter_context(StopRequests())
        recorder = stack.enter_context(start_recorder(path, waits=not driver.in_real_time))
        sinks = [recorder, *(stack.enter_context(other) for other in viewers()), *also]
        if driver.in_real_time:
            warn(stack.enter_context(realtime()))
        announcer = stack.enter_context(Announcer(alarm, unknown_at_end(BLOCKED_LOOP).text))
        outcome = perform(driver, job, sinks, head, asked.look, _print_warnings, announcer)
        for sink in sinks:
            sink.put(text_frame(END, run_summary.end(outcome)))
    return outcome, recorder


def _print_warnings(info: Info) -> None:
    """What a person should know before drives are powered."""
    unguarded = "nothing is known to stop the arm by itself if this program dies"
    warn((*info.warnings, *([] if info.dead_man else [unguarded])))


def alarm(text: str) -> None:
    """Print what a person must know at once, and as the last line of a command that the arm moves, or may."""
    if text:
        print_line(complaint(f"exidyn: {text}"))


def warn(warnings: Iterable[str]) -> None:
    """Print warnings on standard error."""
    for warning in warnings:
        print_line(complaint(f"exidyn: warning: {warning}"))


def code_of(outcome: Outcome) -> int:
    """Exit code of a command that moved an arm."""
    if outcome.unsafe:
        return UNSAFE
    return DONE if outcome.stop is None else STOPPED


def print_where(recorder: PipeSink, path: Path, advice: str) -> None:
    """Print where the recording is.

    Args:
        recorder: Which has ended.
        path: That it was to write.
        advice: What to do with a whole recording, behind "exidyn".
    """
    if path.exists():
        print_written(path, advice=f"exidyn {advice}")
    elif part_of(path).exists():
        print(
            f"exidyn: {recorder.failure or 'the recorder did not finish'}; what was written is in "
            f"{part_of(path)}, see exidyn recover",
            file=sys.stderr,
        )
