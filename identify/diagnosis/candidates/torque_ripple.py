"""Torque ripple: waves per turn of the motor, of low numbers or of any number that the residual shows.

Waves that pass the filter of the comparison are candidates. Faster ones are found in the unfiltered torque:
they can only be located, since no row of the fit contains them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...effects import EFFECTS, Effect, Shape, TorqueRipple
from ...model import Model
from ..blocks.prediction import Prediction
from ..blocks.spectral_line import spectral_line
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts import of_effect, on_each_joint

NAME = "torque_ripple"
LOWEST = 1.5
"""Number of waves within the joint's range that distinguishes them from a spring or an offset [-]."""
SLOW = 10.0
"""Percentage of samples slow enough to show the highest frequency within the band of the filter [%]."""
PEAKS = 3
"""Number of frequencies per joint that are tested in each step of the search."""
FINE = 4
"""Oversampling of the frequencies that the range of a joint can distinguish."""
MULTIPLES = 6
"""Number of harmonics of a wave that are tested together; higher ones have little torque."""
WAVES = ("Rcos", "Rsin", "Fcos", "Fsin")
"""Prefixes of the names of wave coefficients."""
LONGEST = 2_000_000
"""Maximum number of position steps in a joint's range; a few megabytes."""
RECORDED = 0.4
"""Highest frequency that a drive's current contains, share of the sampling rate [-]."""
PASSED = 0.7
"""Share of its cut-off up to which a filter passes torque unchanged [-]."""
FEWEST = 1000
"""Fewest samples with a level of noise over position."""


def low(model: Model) -> Iterator[Candidate]:
    """On each joint, low numbers of waves per motor turn, if the joint moves through several of them."""

    def waving(candidate: Candidate, effect: Effect) -> Candidate:
        assert isinstance(effect, TorqueRipple)
        [joint] = candidate.joints
        waves = effect.harmonic * abs(model.robot.gear_ratio[joint]) / (2 * np.pi)
        return replace(candidate, span=LOWEST / waves)

    return on_each_joint(model, NAME, KINDS[NAME], waving)


def ripples(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """The waves per turn of each joint that stand out most in the residual."""
    position, velocity = (_at_rows(runs, name) for name in ("position", "velocity"))
    cutoff = min(run.prepared.decimation.cutoff for run in runs)
    residual = prediction.residual * prediction.rows.weight
    turns = np.abs(model.robot.gear_ratio)
    for joint, name in enumerate(model.robot.joints):
        moves = prediction.rows.weight[:, joint] > 0
        if not np.any(moves):
            continue
        fastest = _fastest(velocity[moves, joint], cutoff)
        for waves, among in _peaks(position[:, joint], residual[:, joint], fastest):
            harmonic, step = waves / turns[joint], fastest / among / turns[joint]
            effect = EFFECTS[NAME](joints=(name,), harmonic=harmonic)  # type: ignore[call-arg]
            known = {
                "among": among,
                "bounds": {"harmonic": Shape("1", harmonic - step, harmonic + step)},
                "kind": f"wave {round(harmonic / step)}",
                "span": LOWEST * 2 * np.pi / waves,
            }

            def of_peak(candidate: Candidate, effect: Effect, known: Mapping[str, Any] = known) -> Candidate:
                return replace(candidate, **known)

            yield of_effect(model, NAME, effect, KINDS[NAME], (joint,), of_peak)


def _fastest(velocity: np.ndarray, cutoff: float) -> float:
    """Waves per turn that a filter [Hz] passes during the slowest motion, of velocities (r,) [rad/s]."""
    return 2 * np.pi * cutoff / max(float(np.percentile(np.abs(velocity), SLOW)), 1e-9)


def _peaks(position: np.ndarray, residual: np.ndarray, fastest: float) -> Iterator[tuple[float, int]]:
    """Waves per turn with most power in a residual (r,) over position (r,) [rad], and their number."""
    waves, power = _spectrum(position, residual, fastest)
    if not len(waves):
        return
    width = 2 * np.pi / float(np.ptp(position))
    power[(waves < LOWEST * max(width, 1.0)) | (waves > fastest)] = 0.0
    power = _over_their_octave(power, waves)
    for _ in range(PEAKS):
        peak = int(np.argmax(power))
        if power[peak] <= 0.0:
            return
        yield float(waves[peak]), max(int(fastest / width), 1)
        power[np.abs(waves - waves[peak]) < 1.5 * width] = 0.0


def _spectrum(position: np.ndarray, values: np.ndarray, fastest: float) -> tuple[np.ndarray, np.ndarray]:
    """Waves per turn, and power of values (r,) over position (r,) [rad]; empty if the joint rests."""
    offset = position - position.min()
    step = np.pi / fastest / 2
    count = int(float(offset.max()) / step) + 2
    if not np.any(offset) or count > LONGEST:
        return np.zeros(0), np.zeros(0)
    size = 1 << int(np.ceil(np.log2(FINE * count)))
    sums = np.bincount(np.minimum((offset / step).astype(int), count - 1), values, size)
    power = np.abs(np.fft.rfft(sums)) ** 2
    return 2 * np.pi * np.arange(len(power)) / (size * step), power


class Line(NamedTuple):
    """Waves of a joint's torque that are too fast for the filter of the comparison."""

    waves: float  # number per turn of the joint
    amplitude: float  # amplitude [N m]
    cutoff: float  # cut-off of a filter that passes them unchanged during the slowest motion [Hz]


def line_above_cutoff(runs: Sequence[Driven], joint: int) -> Line | None:
    """Waves over position that stand out in the unfiltered torque of a joint; None without any."""
    samples = [
        np.stack([run.motion.position[:, joint], run.motion.velocity[:, joint], _unfiltered(run, joint)])
        for run in runs
    ]
    slides = [run.prepared.sliding[:, joint] for run in runs]
    position, velocity, torque = np.concatenate(
        [values[:, sliding] for values, sliding in zip(samples, slides, strict=True)], axis=1
    )
    if len(torque) < FEWEST:
        return None
    decimations = [run.prepared.decimation for run in runs]
    cutoff = min(decimation.cutoff for decimation in decimations)
    slow = _fastest(velocity, cutoff)
    fast = _fastest(velocity, RECORDED * min(decimation.rate for decimation in decimations))
    waves = _shared_by_halves(position, torque, slow, fast)
    if waves is None:
        return None
    amplitude = 2.0 * abs(np.mean(torque * np.exp(-1j * waves * position)))
    return Line(waves, float(amplitude), waves / slow * cutoff / PASSED)


def _unfiltered(run: Driven, joint: int) -> np.ndarray:
    """Recorded torque of a joint minus that of the fitted model, at full rate, shape (t,) [N m]."""
    return np.asarray((run.prepared.gain * run.prepared.current - run.torque)[:, joint])


def _shared_by_halves(position: np.ndarray, torque: np.ndarray, slow: float, fast: float) -> float | None:
    """Waves per turn between two limits that stand out in both halves of a torque (t,); None without any."""
    first = np.arange(len(torque)) < len(torque) // 2
    halves = [_spectrum(position, torque * half, fast) for half in (first, ~first)]
    waves, powers = halves[0][0], np.array([power for _, power in halves])
    inner = (waves > slow) & (waves <= fast)
    place = spectral_line(powers[:, inner], FINE)
    return None if place is None else float(waves[inner][place])


def _over_their_octave(power: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """Powers over the median of their octave, so that neither end of the spectrum dominates."""
    octave = np.floor(np.log2(np.maximum(waves, 1e-9))).astype(int)
    ratio = np.zeros_like(power)
    for number in np.unique(octave[power > 0.0]):
        within = (octave == number) & (power > 0.0)
        ratio[within] = power[within] / np.median(power[within])
    return ratio


def _at_rows(runs: Sequence[Driven], name: str) -> np.ndarray:
    """A quantity of the motion at the rows of all runs, shape (r, n)."""
    return np.concatenate([getattr(run.motion, name)[run.centres] for run in runs])


def amplitude(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Amplitude: root of the sum of squares of all waves."""
    waves = [name for name in finding.parameters if name.startswith(WAVES)]
    return {"wave": length(finding.parameters, *waves)} if waves else {}


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Amplitude, and what a turn refers to: the motor, or the joint if the gear ratio is unknown."""
    turning = "its motor" if finding.geared else "the joint"
    return {**amplitude(finding, known), "turning": turning}


KINDS = {
    "torque_ripple": Kind(
        family="waves",
        sentence="{joint} has torque ripple[, {harmonic:bare} times per turn of {turning}]: {wave}",
        drawn_against=("motor angle", "position"),
        ask=low,
        ask_of_rest=ripples,
        shapes=(*({"harmonic": float(k)} for k in (1, 2, 3, 4, 6)), {"count": MULTIPLES}),
        derived=_derived,
        settled_by="slow sweeps (exidyn excite --kind sweeps)",
    )
}
