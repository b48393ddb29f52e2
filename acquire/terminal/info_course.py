"""How a run went: its cycles, what happened, and how it ended."""

from collections.abc import Mapping

import numpy as np

from exidyn.identify.recordings.recording import Recording
from exidyn.identify.recordings.run_log import Event, Timing
from exidyn.identify.text_table import paragraph

SHOWN = 40
"""Events that are printed; of more than that, the first and last half."""


def course_lines(recording: Recording) -> list[str]:
    """Cycles, events and outcome of a recorded run, in lines; none for one that was imported."""
    lines = _cycles(recording.timing) if recording.timing is not None else []
    if recording.events:
        lines += ["events", *_events(recording.events)]
    return lines + _outcome(recording.outcome)


def _cycles(timing: Timing) -> list[str]:
    if not len(timing):
        return ["not one cycle"]
    late = np.percentile(1e3 * timing.lateness, [50, 99, 100])
    spent = [
        f"{name} {np.count_nonzero(timing.stage == place)}"
        for place, name in enumerate(timing.stages)
        if np.any(timing.stage == place)
    ]
    return [
        f"{len(timing)} cycles ({', '.join(spent)}), {timing.skipped.sum()} skipped",
        "lateness median {:.3f}, 99 % {:.3f}, largest {:.3f} ms".format(*late),
    ]


def _events(events: tuple[Event, ...]) -> list[str]:
    lines = []
    for place, event in enumerate(events):
        if SHOWN // 2 <= place < len(events) - SHOWN // 2:
            continue
        if place == len(events) - SHOWN // 2 and len(events) > SHOWN:
            lines.append(f"  ... and {len(events) - SHOWN} more ...")
        first = f"  {event.time:10.3f} s  {event.kind:<8}  "
        lines += paragraph(event.text, " " * len(first), first)
    return lines


def _outcome(outcome: Mapping[str, str]) -> list[str]:
    if "stop" not in outcome:
        return []
    text = outcome.get("text") or " ".join(filter(None, (outcome["stop"], outcome.get("joint"))))
    how = {
        "none": text,
        "unknown": "nobody said how; the program that moved the arm, or the recorder, ended before it could",
    }.get(outcome["stop"], f"STOPPED ({outcome.get('level', 'brake').lower()}): {text}")
    first = "ended:  "
    return paragraph(how, " " * len(first), first)
