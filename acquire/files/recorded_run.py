"""A run of an arm with its recorder and viewers, for every command that moves an arm."""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from exidyn.drivers import Driver, Info, Sample
from exidyn.drivers.host_clock import HOST
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload

from ..arguments.parser import DONE, STOPPED, UNSAFE, complaint
from ..run.announcer import BLOCKED, Announcer
from ..run.errors import print_line
from ..run.frames import END, text_frame
from ..run.perform import Job, Outcome, perform
from ..run.pipe import PipeSink, Sink
from ..run.realtime import realtime
from ..run.recorder import RunHead, part_of, start_recorder
from ..run.stopping.stop import StopRequests, unknown_at_end
from ..terminal import run_summary
from ..terminal.json_output import hand_over, json_text, print_next, print_written

BLOCKED_LOOP = f"the driver or this computer has been blocked for {BLOCKED:g} s"
"""Warning while the loop is blocked."""


def free_path(wanted: Path | None, stem: str) -> Path:
    """The wanted path, or the first of stem.mcap, stem-2.mcap, ... that does not exist."""
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
    """The head of a recording, which describes the run, as a function of its first sample.

    `more` has further facts, name -> text; empty texts are omitted.
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
    head_at = RunHead(
        name=name,
        model=model,
        signals=info.signals,
        trajectory=trajectory,
        payload=payload,
        settings={name: text for name, text in settings.items() if text},
        warnings=info.warnings,
        state=info.state,
    ).prepare_frame()
    return lambda sample: head_at(sample.host_time, sample.controller_time)


def run_recorded(
    driver: Driver,
    job: Job | Callable[[Info], Job],
    path: Path,
    head: Callable[[Info], Callable[[Sample], bytes]],
    viewers: Callable[[], Iterable[PipeSink]] = tuple,
    also: Sequence[Sink] = (),
) -> tuple[Outcome, PipeSink]:
    """Start the recorder and the viewers, run, and wait until the recording is written.

    See `perform` for the job and `run_head` for the head. `viewers` starts further processes that receive the
    run, and `also` are sinks of every cycle in this process. The returned recorder has ended.
    """

    def print_warnings(info: Info) -> None:  # before drives are powered
        unguarded = "no known mechanism stops the arm if this program dies"
        warn((*info.warnings, *([] if info.dead_man else [unguarded])))

    with ExitStack() as stack:
        # First in, last out: a Ctrl-C while the recorder finishes must not end it.
        requests = stack.enter_context(StopRequests())
        in_real_time = driver.in_real_time and driver.clock is HOST
        recorder = stack.enter_context(start_recorder(path, waits=not in_real_time))
        sinks = [recorder, *(stack.enter_context(other) for other in viewers()), *also]
        if in_real_time:
            warn(stack.enter_context(realtime()))
        announcer = stack.enter_context(Announcer(alarm, unknown_at_end(BLOCKED_LOOP).text))
        outcome = perform(driver, job, sinks, head, requests.look, print_warnings, announcer)
        for sink in sinks:
            sink.put(text_frame(END, run_summary.end(outcome)))
    return outcome, recorder


def alarm(text: str) -> None:
    """Print an urgent message: that the arm moves, or may move."""
    if text:
        print_line(complaint(f"exidyn: {text}"))


def warn(warnings: Iterable[str]) -> None:
    """Print warnings on standard error."""
    for warning in warnings:
        print_line(complaint(f"exidyn: warning: {warning}"))


def report_run(
    outcome: Outcome,
    recorder: PipeSink,
    path: Path,
    advice: str,
    page: str,
    table: Mapping[str, Any],
    json: Path | None,
) -> int:
    """Print the page or the JSON of a run, where its recording is, and an alarm; return the exit code.

    `advice` is the next command for a complete recording, without "exidyn".
    """
    hand_over(page, json_text({**table, "written": str(path)}), json)
    if path.exists():
        print_written(path)
        print_next(advice)
    elif part_of(path).exists():
        print(
            f"exidyn: {recorder.failure or 'the recorder did not finish'}; what was written is in "
            f"{part_of(path)}, see exidyn info --repair",
            file=sys.stderr,
        )
    alarm(outcome.unsafe)
    if outcome.unsafe:
        return UNSAFE
    return DONE if outcome.stop is None else STOPPED
