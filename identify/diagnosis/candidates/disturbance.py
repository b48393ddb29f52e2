"""Disturbance: torque that is periodic in time, whatever the arm does.

A pump, a fan or a power supply acts on an arm without being part of it. Its torque is reported as unexplained
and dependent on time. It is tested so that no effect of the arm is named instead.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ...effects import Shape
from ...model import Model
from ..blocks.prediction import Prediction
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import Formatted, length
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..runs.usable import HELD_OUT
from .parts import RARE, on_joint

NAME = "periodic_disturbance"
SLOWEST = 4.0
"""Minimum number of periods in the shortest run: slower residuals are drift."""
FINE = 8
"""Oversampling of the frequencies that runs distinguish, so that a wave keeps its phase to 1/16 period."""
MAIN = 0.5
"""Minimum share of the squared residual that one wave explains [-]: missing physics leaves many waves, at
multiples of the motion's lowest frequency."""
MOVED = 0.5
"""Maximum share of a wave that the motion itself contains [-]; a swing at one frequency contains it all."""


def disturbances(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """On each joint, the wave in time that dominates the residual, if the motion has no such wave."""
    fitted = [run for run in runs if run.role != HELD_OUT]
    names = tuple(run.prepared.name for run in runs)
    moving = np.concatenate([_moving(run) for run in fitted])
    for joint in range(model.robot.dof):
        residuals = [
            prediction.residual[rows, joint] * prediction.rows.weight[rows, joint]
            for rows in prediction.rows.runs[: len(fitted)]
        ]
        frequency, step, among = _strongest(residuals, prediction.rate)
        if not frequency:
            continue
        waves = [_waves(run.motion.time[run.centres], frequency) for run in fitted]
        pairs = zip(waves, residuals, strict=True)
        unexplained = sum(_unexplained(wave, residual[:, None]) for wave, residual in pairs)
        if unexplained > (1.0 - MAIN) * sum(float(residual @ residual) for residual in residuals):
            continue
        if _unexplained(moving, np.concatenate(waves)) > (1.0 - MOVED) * sum(wave.size / 2 for wave in waves):
            yield _disturbance(joint, frequency, step, names, len(fitted), among)


def _disturbance(
    joint: int, frequency: float, step: float, names: tuple[str, ...], fitted: int, among: int
) -> Candidate:
    """One wave with a separate phase in each run; a held-out run alone shows its own."""
    count = 2 * len(names)
    unnamed = tuple(f"{UNNAMED}{place}" for place in range(count - 2 * fitted))

    def columns(run: Driven) -> np.ndarray:
        torque, place = np.zeros((len(run.motion), count)), 2 * names.index(run.prepared.name)
        torque[:, place : place + 2] = _waves(run.motion.time, frequency)
        return on_joint(run, joint, torque)

    return Candidate(
        NAME, (joint,), columns, (*_names(fitted), *unnamed), ("N m",) * count, (-np.inf,) * count,
        {"frequency": frequency},
        {"frequency": Shape("Hz", frequency - step, frequency + step)},
        lambda shape: _disturbance(joint, shape["frequency"], step, names, fitted, among),
        rows=(joint,), among=among, prior=RARE, by_run=True, listed=False,
    )  # fmt: skip


def _names(runs: int) -> tuple[str, ...]:
    return tuple(f"{wave}{run + 1}" for run in range(runs) for wave in ("cos", "sin"))


def _waves(time: np.ndarray, frequency: float) -> np.ndarray:
    """Cosine and sine at times (t,) [s], shape (t, 2)."""
    angle = 2 * np.pi * frequency * time
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _strongest(residuals: Sequence[np.ndarray], rate: float) -> tuple[float, float, int]:
    """Strongest frequency of the runs' residuals [Hz], the frequency step, and the number of frequencies."""
    longest, shortest = (extreme(map(len, residuals)) for extreme in (max, min))
    size = FINE * 2 ** int(np.ceil(np.log2(longest)))
    power = sum(np.abs(np.fft.rfft(run * np.hanning(len(run)), size)) ** 2 for run in residuals)
    frequency = np.arange(size // 2 + 1) * rate / size
    inside = frequency > SLOWEST * rate / shortest
    place = int(np.argmax(np.where(inside, power, 0.0)))
    among = max(int(np.count_nonzero(inside) * longest / size), 1)
    return (float(frequency[place]) if inside[place] else 0.0), rate / longest, among


def _moving(run: Driven) -> np.ndarray:
    """Position, velocity, its sign and acceleration of all joints at the rows, shape (r, 4 n + 1)."""
    motion, at = run.motion, run.centres
    signals = motion.position, motion.velocity, np.sign(motion.velocity), motion.acceleration
    return np.concatenate([*(values[at] for values in signals), np.ones((len(at), 1))], axis=1)


def _unexplained(columns: np.ndarray, values: np.ndarray) -> float:
    """Sum of squares of values (r, m) that columns (r, p) do not explain."""
    return float(np.sum((values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]) ** 2))


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Amplitude of the wave, root mean square over its runs."""
    runs = sum(name.startswith("cos") for name in finding.parameters)
    size = length(finding.parameters, *_names(runs))
    return {"size": Formatted(size.value / np.sqrt(runs), size.std / np.sqrt(runs), size.unit)}


KINDS = {
    NAME: Kind(
        family="time",
        sentence="{joint} has torque that is unexplained and depends on time: it is periodic[, at "
        "{frequency:bare} Hz], whatever the arm does, with an amplitude of {size}",
        drawn_against=("time", "position"),
        ask=lambda model: iter(()),
        ask_of_rest=disturbances,
        derived=_derived,
        sensor=True,
    )
}
