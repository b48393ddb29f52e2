"""Checks of a recording: what is impossible raises an error or a warning, what is unusual a warning.

An error: identifying from this would be wrong; a warning: a person should look at this. A table
from elsewhere in which a joint is at 90 rad is in degrees, and refused. In what exidyn recorded itself, the
joint ran away: such a recording is opened whatever is in it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arm.robot import Limits
from ..errors import BadUnit
from .arrival_times import signals_by_stamps, with_regular_clocks
from .effort_checks import effort_warnings
from .incomplete_samples import finite, without_impossible, without_repeats, without_silence
from .recording import Recording
from .recording_findings import findings
from .restored_signals import restored, without_saturated

GAP = 1.5
"""A step of more median periods than this misses at least one sample, if the clock is regular."""
AS_PLANNED = "none"
"""Stop in the outcome of a run that came to its end."""
BEYOND_LIMITS = 0.1
"""Distance beyond a limit from which there is a warning [rad, m]: encoders read slightly more than the limits
that controllers enforce."""


def check(recording: Recording, in_si: bool = True) -> Recording:
    """The recording without silent samples, and with its warnings.

    Of a log from elsewhere, turns and signs that were lost are restored, and samples that only repeat the one
    before are left out. What exidyn recorded was measured in the units it states; a value that no joint
    should have gives a warning, and samples that are no numbers or whose time goes back are left out.

    Args:
        recording: Recording as it was read.
        in_si: Whether its units are known; otherwise a value that no joint should have gives a warning.

    Raises:
        NotFinite: A joint that was measured has NaN or infinity in between.
        BadTime: Time stamps do not increase.
        BadUnit: Positions, times or temperatures that cannot be in the unit they claim.
    """
    recording = without_repeats(without_silence(recording))
    if recording.recorded:
        recording = without_impossible(recording)
    else:
        recording = without_saturated(restored(with_regular_clocks(recording)))
    warnings = []
    for finding in findings(recording):
        if finding.kind is not BadUnit or (in_si and not recording.recorded):
            raise finding.error(recording.name)
        warnings.append(finding.fact)
    return _with_warnings(recording, warnings)


def check_recorded(recording: Recording) -> Recording:
    """A recording that exidyn wrote, without silent samples, and with a warning for all that cannot be."""
    recording = without_silence(replace(recording, recorded=True))
    return _with_warnings(recording, [finding.fact for finding in findings(recording)])


class DerivedWarning(str):
    """A warning that follows from the recording itself, so that the checks give it anew."""

    __slots__ = ()


def _with_warnings(recording: Recording, impossible: Sequence[str]) -> Recording:
    facts = [*_stopped(recording), *_gaps(recording)]
    if len(recording.signals["position"]):
        facts += _beyond_limits(recording)
    derived = [DerivedWarning(fact) for fact in (*facts, *effort_warnings(recording), *impossible)]
    # Gaps are counted anew, since samples may have been lost since.
    valid = (
        warning
        for warning in recording.warnings
        if warning in derived or not isinstance(warning, DerivedWarning)
    )
    return replace(recording, warnings=tuple(valid)).with_warnings(*derived)


def _stopped(recording: Recording) -> list[str]:
    """That a run was stopped before its motion came to its end, and why."""
    outcome = recording.outcome
    if outcome.get("stop", AS_PLANNED) == AS_PLANNED:
        return []
    why = outcome.get("text") or " ".join(filter(None, (outcome["stop"], outcome.get("joint"))))
    return [f"was stopped early, after {recording.duration:.3g} s: {why}"]


def _gaps(recording: Recording) -> list[str]:
    """Warnings about time stamps with holes, once for all signals that share the stamps or the holes."""
    names_by_fact: dict[str, list[str]] = {}
    for names in signals_by_stamps(recording):
        signal = recording.signals[names[0]]
        steps = np.diff(signal.time)
        long = steps > GAP * signal.period
        if long.any():
            fact = (
                f"{long.sum()} gap{'s' * bool(long.sum() > 1)} of more than {GAP} median periods of "
                f"{signal.period * 1e3:.3f} ms, the longest {steps.max() * 1e3:.3f} ms, the first at "
                f"{signal.time[:-1][long][0]:.3f} s"
            )
            names_by_fact.setdefault(fact, []).extend(names)
    return [f"{', '.join(names)}: {fact}" for fact, names in names_by_fact.items()]


def _beyond_limits(recording: Recording) -> list[str]:
    beyond = beyond_limits(recording.robot.limits, recording.signals["position"].values)
    return [
        f"position: {recording.robot.joints[joint]} goes {beyond[joint]:.3g} rad or m beyond its limits; is "
        "its zero where the robot's description has it?"
        for joint in np.flatnonzero(beyond > BEYOND_LIMITS)
    ]


def beyond_limits(limits: Limits, position: np.ndarray) -> np.ndarray:
    """Largest distance of positions (t, n) beyond the limits of each joint, negative within them, (n,)."""
    columns = [finite(column) for column in position.T]
    lowest = np.array([np.min(column, initial=np.inf) for column in columns])
    highest = np.array([np.max(column, initial=-np.inf) for column in columns])
    return np.maximum(limits.position_lower - lowest, highest - limits.position_upper)
