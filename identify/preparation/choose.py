"""Filters that were not given, chosen from a recording."""

from dataclasses import replace

from ..recordings.recording import Recording
from . import cutoffs
from .even import Even, whole_motion
from .filtering import Filtering
from .smoothing import recorded_band

SHORTEST = 30.0
"""Periods of the torque's cut-off in a run, at least: three times the length of its filter."""


def choose(recording: Recording, filtering: Filtering) -> Filtering:
    """The filtering, with what it leaves open chosen from a recording.

    Raises:
        RecordingError: Too short to have a spectrum, or a cut-off that no filter can have.
    """
    even = Even.of(recording, filtering.rate)
    filtering.check_cutoffs(even.rate, recording.name)
    position_cutoff = filtering.position_cutoff or cutoffs.position_cutoff(even.position, even.rate)
    torque_cutoff = filtering.torque_cutoff or min(
        cutoffs.torque_cutoff(recording.model, even.position, even.current, even.gain, even.rate),
        _recorded_up_to(even, position_cutoff),
    )
    # Positions are low-passed first: beyond 0.7 of that cut-off accelerations are short.
    torque_cutoff = min(torque_cutoff, 0.7 * position_cutoff)
    return replace(filtering, rate=even.rate, position_cutoff=position_cutoff, torque_cutoff=torque_cutoff)


def recorded_up_to(recording: Recording, filtering: Filtering) -> float:
    """Frequency up to which torque or current was recorded [Hz], as far as the run is long enough for it.

    Args:
        recording: One run.
        filtering: As chosen for it.
    """
    return _recorded_up_to(Even.of(recording, filtering.rate), float(filtering.position_cutoff or 0.0))


def _recorded_up_to(even: Even, position_cutoff: float) -> float:
    band = recorded_band(even.recording.model, whole_motion(even, position_cutoff), even.current, even.rate)
    return max(band, SHORTEST * even.rate / len(even.time))
