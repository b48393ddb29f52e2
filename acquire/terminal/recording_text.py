"""Contents of a recording: as lines for a person, and as a plain table for JSON."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exidyn.identification.document.document import Code, Document, Section, Statements, Table
from exidyn.identification.document.text import blocks_lines, fact_lines
from exidyn.identification.effects import name_of
from exidyn.identification.recordings.align import follows_by
from exidyn.identification.recordings.recording import (
    SIGNALS,
    ControllerState,
    Event,
    Recording,
    Signal,
    Timing,
)
from exidyn.identification.text_table import INDENT, UNKNOWN, digits, paragraph, table
from exidyn.quoting import one_line

SHOWN = 40
"""Largest number of events that are printed; of more, the first and last half of this number."""
SHOWN_STATES = 8
"""Largest number of changes of a controller state that are printed."""


def recordings_document(recordings: Sequence[Recording]) -> Document:
    """Contents of recordings; in short what was recorded, how it ended, and the signals."""
    sections = [Section("", recording.name, [Code(describe(recording))]) for recording in recordings]
    brief = [
        block for recording in recordings for block in (Statements(_said(recording)), _signals(recording))
    ]
    return Document(
        ", ".join(one_line(recording.name) for recording in recordings), "", sections, brief=brief
    )


def _said(recording: Recording) -> list[str]:
    """Robot, duration, payload and origin of a recording; its end and warnings; its course."""
    origin = [f"driver {driver}"] if (driver := recording.settings.get("driver")) else []
    facts = [f"{recording.duration:.3f} s", f"payload {payload_words(recording)}", *origin]
    cycles = "; ".join(_cycles(recording.timing)) if recording.timing is not None else ""
    end = " ".join(" ".join(_outcome(recording.outcome)).split())
    warnings = [f"warning: {warning}" for warning in recording.warnings]
    first, course = f"{recording.robot.name}: {', '.join(facts)}", (cycles, *_following(recording))
    return list(filter(None, (first, end, *warnings, *course)))


def describe(recording: Recording) -> str:
    """Robot, payload, settings, signals, ranges, course and warnings of a recording, as lines."""
    robot = recording.robot
    facts = {
        "robot": f"{robot.name}: {', '.join(robot.joints)}",
        "model": ", ".join(_effects(recording)),
        "duration": f"{recording.duration:.3f} s",
        "payload": payload_words(recording),
        "trajectory": "inside" if recording.trajectory else "none",
        **{one_line(name): text for name, text in recording.settings.items()},
    }
    lines = [one_line(recording.name), *fact_lines(facts.items())]
    for block in (blocks_lines([_signals(recording)]), _ranges(recording), _course(recording)):
        lines += ["", *(f"  {line}" for line in block)] if block else []
    return "\n".join(lines + warning_lines(recording))


def payload_words(recording: Recording) -> str:
    """The payload on the flange and its known parameters."""
    if recording.payload is None:
        return "none"
    known = ", ".join(f"{name} {digits(value)}" for name, value in recording.payload.known)
    return f"{recording.payload.name}: {known or 'nothing known'}"


def warning_lines(recording: Recording) -> list[str]:
    """The recording's warnings, one sentence each."""
    return [line for warning in recording.warnings for line in paragraph(warning, " " * 11, "  warning: ")]


def _signals(recording: Recording) -> Table:
    """Table of the signals: unit, number of samples, rate."""
    rows = [
        [name, _unit(recording, name), str(len(signal)), digits(signal.rate) if signal.rate else UNKNOWN]
        for name, signal in recording.signals.items()
    ]
    return Table(["signal", "unit", "samples", "Hz"], rows, words=(1,))


def _ranges(recording: Recording) -> list[str]:
    """Table of each joint's range in each signal, with the units in its head."""
    columns = [[_range(column) for column in s.values.T] for s in recording.signals.values()]
    rows = [list(row) for row in zip(recording.robot.joints, *columns, strict=True)]
    return table(["joint", *(f"{name} [{_unit(recording, name)}]" for name in recording.signals)], rows)


def _unit(recording: Recording, signal: str) -> str:
    """Unit of a signal; if revolute and prismatic joints have different units, both."""
    return ", ".join(dict.fromkeys(recording.robot.units(SIGNALS[signal])))


def _range(column: np.ndarray) -> str:
    known = column[np.isfinite(column)]
    if not len(known):
        return "-"
    return f"{known.min():.3g} .. {known.max():.3g}"


def _course(recording: Recording) -> list[str]:
    """Cycles, events and outcome of a recorded run, as lines; none for an imported recording."""
    cycles = _cycles(recording.timing) if recording.timing is not None else []
    lines = [line for sentence in cycles for line in paragraph(sentence, "  ", "", INDENT)]
    lines += _following(recording)
    if (state := recording.controller) is not None:
        values = (f"{name.replace('_', ' ')} {_reported(state, name)}" for name in state.words)
        lines += paragraph("; ".join(values), "  ", "controller: ", INDENT)
    if recording.events:
        lines += ["events", *_events(recording.events)]
    return lines + _outcome(recording.outcome)


def _cycles(timing: Timing) -> list[str]:
    if not len(timing):
        return ["no cycles"]
    late = np.percentile(1e3 * timing.lateness, [50, 99, 100])
    spent = [
        f"{name} {np.count_nonzero(timing.stage == place)}"
        for place, name in enumerate(timing.stages)
        if np.any(timing.stage == place)
    ]
    cycles = f"{len(timing)} cycles ({', '.join(spent)}), {timing.skipped.sum()} skipped"
    return [cycles, "lateness median {:.3f}, 99 % {:.3f}, largest {:.3f} ms".format(*late)]


def _following(recording: Recording) -> list[str]:
    """Delay between commands and positions; empty if the motion does not show it."""
    if recording.timing is None or "command" not in recording.signals:
        return []
    latency = follows_by(recording.signals["command"], recording.signals["position"])
    return [f"positions follow commands by {1e3 * latency:.1f} ms"] if np.isfinite(latency) else []


def _reported(state: ControllerState, name: str) -> str:
    """States of the controller in order; the range of values that are plain numbers."""
    values = state.of(name)
    if not state.words[name]:
        return _range(values)
    codes = values[np.isfinite(values)].astype(int)
    changed = codes[np.flatnonzero(np.diff(codes, prepend=codes[:1] - 1))].tolist()
    shown = [state.words[name].get(code, f"code {code}") for code in changed]
    return ", ".join(shown[:SHOWN_STATES]) + ", ..." * (len(shown) > SHOWN_STATES) or "-"


def _events(events: tuple[Event, ...]) -> list[str]:
    lines = []
    for place, event in enumerate(events):
        if SHOWN // 2 <= place < len(events) - SHOWN // 2:
            continue
        if place == len(events) - SHOWN // 2 and len(events) > SHOWN:
            lines.append(f"  ... and {len(events) - SHOWN} more ...")
        first = f"  {event.time:10.3f} s  {event.kind:<8}  "
        lines += paragraph(event.text, " " * len(first), first, INDENT)
    return lines


def _outcome(outcome: Mapping[str, str]) -> list[str]:
    """How a run ended: as planned, or stopped, with the reason, and whether the arm still moves."""
    if "stop" not in outcome:
        return []
    text = outcome.get("text") or " ".join(filter(None, (outcome["stop"], outcome.get("joint"))))
    how = {
        "none": text,
        "unknown": "unknown; the program that moved the arm, or the recorder, ended before it could",
    }.get(outcome["stop"], f"STOPPED ({outcome.get('level', 'brake').lower()}): {text}")
    if outcome.get("moving", "False") != "False":
        how += f". {outcome.get('standstill', '')}"
    first = "ended:  "
    return paragraph(how, " " * len(first), first, INDENT)


def recording_table(recording: Recording) -> dict[str, Any]:
    """Robot, signals, payload, settings, cycles, events, outcome and warnings, for JSON."""
    payload, timing, state = recording.payload, recording.timing, recording.controller
    return {
        "name": recording.name,
        "robot": recording.robot.name,
        "joints": list(recording.robot.joints),
        "effects": _effects(recording),
        "duration": recording.duration,
        "payload": payload and {"name": payload.name, "known": dict(payload.known)},
        "trajectory": bool(recording.trajectory),
        "settings": dict(recording.settings),
        "signals": {name: _signal_table(name, signal) for name, signal in recording.signals.items()},
        "cycles": None if timing is None else _cycle_table(timing),
        "controller": None if state is None else {name: _reported(state, name) for name in state.words},
        "events": [{"time": e.time, "kind": e.kind, "text": e.text} for e in recording.events],
        "outcome": dict(recording.outcome),
        "warnings": list(recording.warnings),
    }


def _signal_table(name: str, signal: Signal) -> dict[str, Any]:
    """Unit, number of samples, rate, and the range of each joint."""
    known = [column[np.isfinite(column)] for column in signal.values.T]
    return {
        "unit": SIGNALS[name],
        "samples": len(signal),
        "rate_hz": float(signal.rate),
        "lower": [np.min(column, initial=np.inf) for column in known],
        "upper": [np.max(column, initial=-np.inf) for column in known],
    }


def _cycle_table(timing: Timing) -> dict[str, Any]:
    """Numbers of cycles and percentiles of their lateness [s]."""
    late = np.percentile(timing.lateness, [50, 99, 100]) if len(timing) else np.full(3, np.nan)
    return {
        "cycles": len(timing),
        "skipped": int(timing.skipped.sum()),
        "lateness_p50": late[0],
        "lateness_p99": late[1],
        "lateness_max": late[2],
    }


def _effects(recording: Recording) -> list[str]:
    """Distinct names of the model's effects."""
    return list(dict.fromkeys(name_of(effect) for effect in recording.model.effects))
