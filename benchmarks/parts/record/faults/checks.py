"""What must be so after a fault, each as a check that names in words what is not."""

import numpy as np

from exidyn.drivers import StopLevel
from exidyn.identification.recordings.recording import Recording

from .fault import Check, Seen

SOON = 1.0
"""An arm that stops is at rest within this time [s]; twice what a jerk-limited stop from full speed takes."""
MOMENT = 500
"""Cycles of the motion after which the fault comes."""


def all_recorded(seen: Seen) -> str:
    """Each cycle that the loop has made is in the recording, which contains how the run ended."""
    made = seen.ran.outcome.counts.cycles
    kept = len(seen.recording.timing) if seen.recording.timing is not None else 0
    if kept != made:
        return f"{made - kept} of {made} cycles are not in the recording"
    return "" if seen.ran.path.exists() else "the recording was not finished"


def no_jump(seen: Seen) -> str:
    """No command is further from the one before than the fastest joint could go."""
    command = seen.recording.signals.get("command")
    if command is None or len(command) < 2:
        return ""
    fastest = seen.recording.robot.limits.velocity * seen.ran.outcome.info.cycle
    share = np.max(np.abs(np.diff(command.values, axis=0)) / fastest)
    return "" if share <= 1.05 else f"a command jumps by {share:.1f} times what the limits allow"


def goes_on(seen: Seen) -> str:
    """The motion comes to its end."""
    stop = seen.ran.outcome.stop
    return f"stopped: {stop.text}" if stop else ""


def stops(level: StopLevel, *kinds: str) -> Check:
    """It is stopped that hard and no harder, for one of these reasons."""

    def check(seen: Seen) -> str:
        stop, escalated = seen.ran.outcome.stop, seen.ran.outcome.escalated
        if stop is None:
            return "not stopped"
        if escalated:
            return f"escalated, though the stop works: {escalated[0].text}"
        if stop.kind not in kinds:
            return f"stopped for another reason: {stop.text}"
        return "" if stop.level == level else f"stopped by {stop.level.name}, not {level.name}"

    return check


def comes_to_rest(seen: Seen) -> str:
    """The arm is at rest soon after the stop."""
    took = seen.stopping_time
    return "" if took <= SOON else f"still moving {took:.2f} s after the stop"


def missing(least: int, most: int) -> Check:
    """So many cycles were missed or had a silent joint."""

    def check(seen: Seen) -> str:
        counts = seen.ran.outcome.counts
        found = counts.skipped + counts.stale
        return "" if least <= found <= most else f"{found} cycles missed, expected {least} to {most}"

    return check


def ends_orderly(seen: Seen) -> str:
    """The motion comes to its end, or to a stop by the controller's own means."""
    stop = seen.ran.outcome.stop
    return "" if stop is None or stop.level == StopLevel.QUICK else f"stopped: {stop.text}"


def reports(text: str) -> Check:
    """An event reports it."""

    def check(seen: Seen) -> str:
        reported = any(text in event.text for event in seen.recording.events)
        return "" if reported else f"no event contains '{text}'"

    return check


def in_state(name: str, value: float) -> Check:
    """The recording has the controller in that state."""

    def check(seen: Seen) -> str:
        state = seen.recording.controller
        found = state is not None and value in state.of(name)
        return "" if found else f"the recorded {name} is never {value:g}"

    return check


def peer_says(text: str, count: int = 1) -> Check:
    """The controller reports it itself."""

    def check(seen: Seen) -> str:
        return (
            ""
            if seen.messages.count(text) >= count
            else f"the controller did not report '{text}' {count} times"
        )

    return check


def nothing_commanded(seen: Seen) -> str:
    """Not one command was sent, and the arm has not moved."""
    if "command" in seen.recording.signals and len(seen.recording.signals["command"]):
        return "something was commanded"
    return "the arm has moved" if seen.last_motion else ""


def time_goes_on(seen: Seen) -> str:
    """No sample has the time of the one before, or an earlier one."""
    step = np.diff(seen.recording.signals["position"].time)
    return "" if np.all(step > 0.0) else f"{np.sum(step <= 0.0)} samples do not come after the one before"


def no_old_samples(seen: Seen) -> str:
    """Measurements do not come later behind the commands after a fault than before it."""
    position, cycle = seen.recording.signals["position"], seen.ran.outcome.info.cycle
    begun = [e.time for e in seen.recording.events if e.kind == "stage" and e.text == "running"]
    began = begun[0] if begun else np.inf
    hole = int(np.searchsorted(position.time, began + MOMENT * cycle))
    if not 100 < hole < len(position) - 100:
        return "the motion ended before the fault"
    before, after = (delay(seen.recording, rows) for rows in (slice(0, hole), slice(hole + 1, None)))
    if abs(after - before) < 0.5 * cycle:
        return ""
    return f"measurements are {1e3 * (after - before):.1f} ms older after the fault than before"


def delay(recording: Recording, rows: slice) -> float:
    """By how much positions are behind commands, in least squares over all joints [s]; NaN at rest."""
    command, position = recording.signals["command"], recording.signals["position"][rows]
    inside = (position.time >= command.time[0]) & (position.time <= command.time[-1])
    columns = []
    for values in (command.values, np.gradient(command.values, command.time, axis=0)):
        columns.append([np.interp(position.time[inside], command.time, joint) for joint in values.T])
    commanded, velocity = np.array(columns)
    moved = np.sum(velocity**2)
    behind = np.sum((commanded - position.values[inside].T) * velocity)
    return float(behind / moved) if moved else float("nan")
