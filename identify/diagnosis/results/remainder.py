"""Remainder: the residual with all findings, and the recorded quantities on which it depends.

The residual is tested for smooth functions of recorded quantities: powers, waves and products. These are
features without physics; whatever they explain is missing in the model and has no name.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ...text_table import digits
from ..blocks.prediction import Prediction
from ..blocks.spectral_line import LINES, spectral_line
from ..candidates.parts import on_joint
from ..candidates.torque_ripple import PASSED, line_above_cutoff
from ..findings.evidence import UNCERTAIN, Remainder
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.comparison import colouring, explained_variance
from ..questions.question import ask
from ..runs.driven import Driven
from ..search.problem import Problem
from ..search.search import SearchResult
from ..search.selected import odds_of

Feature = Callable[[Driven, int], list[np.ndarray]]
WAVES = 6
"""Number of half waves over a run for drifts; variations within seconds count as noise."""
CREDIBLE = 0.99
"""Probability from which on a remainder is reported."""
MATERIAL = 0.3
"""Remainder, relative to the noise floor, below which it changes the residual by less than 5 % and is not
worth a run [-]."""
MAIN = 0.7
"""`MATERIAL` without a noise floor, when the residual itself is the level: half of its square [-]."""
SLOWEST = 1.0
"""Lowest frequency of a vibration; slower waves are motions [Hz]."""
FEWEST = 64
"""Fewest rows of a run with a spectrum."""
BEYOND = 2.0
"""Residual over the noise floor above which a remainder is reported even without a dependence [-]: moving
drives are noisier than drives at rest, but their noise has less than four times the power."""
GUESSED = 10.0
"""`BEYOND` for a noise floor that was guessed from high frequencies [-]: noise has more power at low
frequencies, but never a hundred times as much."""


def _position(run: Driven, joint: int) -> list[np.ndarray]:
    q = run.motion.position[:, joint]
    return [f(k * q) for k in (1, 2, 3) for f in (np.cos, np.sin)]


def _velocity(run: Driven, joint: int) -> list[np.ndarray]:
    v = run.motion.velocity[:, joint]
    return [*(smooth_sign(v, width) for width in (0.01, 0.03, 0.1, 0.3)), np.abs(v), v**3]


def _sign(run: Driven, joint: int) -> np.ndarray:
    return smooth_sign(run.motion.velocity[:, joint])


def _position_and_direction(run: Driven, joint: int) -> list[np.ndarray]:
    sign = _sign(run, joint)
    return [sign * wave for wave in _position(run, joint)]


def _load(run: Driven, joint: int) -> list[np.ndarray]:
    share, sign = run.motion.load[:, joint] / max(float(run.most[joint]), 1e-9), _sign(run, joint)
    return [share, share**2, share**3, sign * share, sign * np.abs(share), sign * share**2]


def _acceleration(run: Driven, joint: int) -> list[np.ndarray]:
    return list(run.motion.acceleration.T)


def _time(run: Driven, joint: int) -> list[np.ndarray]:
    """Drifting offsets and dry friction, as half waves over the run."""
    t, sign = run.motion.time - run.motion.time[0], _sign(run, joint)
    turn = np.pi * t / max(float(t[-1]), 1e-9)
    return [kind * np.cos(k * turn) for k in range(1, WAVES + 1) for kind in (np.ones_like(sign), sign)]


def _other_joints(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    return [*(run.torque[:, k] for k in others), *(_sign(run, k) for k in others)]


def _other_positions(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    return [f(run.motion.position[:, k]) for k in others for f in (np.cos, np.sin)]


KINDS: dict[str, Feature] = {
    "position": _position,
    "velocity": _velocity,
    "position and direction": _position_and_direction,
    "load": _load,
    "acceleration": _acceleration,
    "time": _time,
    "other joints' torque or direction": _other_joints,
    "other joints' position": _other_positions,
}


def features(model: Model) -> Iterator[Candidate]:
    """Features of all kinds on each joint."""
    dof = model.robot.dof
    counts = {"position": 6, "velocity": 6, "position and direction": 6, "load": 6}
    counts |= {"acceleration": dof, "time": 2 * WAVES}
    for joint in range(dof):
        for kind, make in KINDS.items():
            count = counts.get(kind, 2 * (dof - 1))

            def columns(run: Driven, joint: int = joint, make: Feature = make) -> np.ndarray:
                return on_joint(run, joint, np.stack(make(run, joint), axis=1))

            if count:
                yield Candidate(kind, (joint,), columns, ("",) * count, ("",) * count, (-np.inf,) * count)


def discrepancies(problem: Problem, prediction: Prediction) -> list[Answer]:
    """Answers of the features of all kinds on each joint, added to the prediction."""
    pairs = [(feature, Thinned.of(feature, problem.runs)) for feature in features(problem.model)]
    answers = ask(prediction, [pair for pair in pairs if not pair[1].empty])
    return [colouring(prediction, answer) if answer.gain > 0.0 else answer for answer in answers]


def remainders(
    prediction: Prediction, answers: list[Answer], noise: np.ndarray, rested: bool, material: float = MATERIAL
) -> list[Remainder]:
    """Joints with an unexplained residual, and the quantity on which it depends.

    Args:
        prediction: Prediction with all findings.
        answers: Answers of features on each joint.
        noise: Noise floor of each joint's torque, shape (n,) [N m].
        rested: Whether the noise was measured at rest; otherwise it was guessed.
        material: Remainder, relative to the noise floor, below which it is not worth a run [-].
    """
    residual = rms(prediction.residual, prediction.rows.weight)
    count, least = len(noise) * len(KINDS), float(np.log(CREDIBLE / (1 - CREDIBLE)))
    rows = []
    for joint in range(len(noise)):
        joint_answers = [answer for answer in answers if answer.candidate.joints == (joint,)]
        best = max(joint_answers, key=lambda answer: answer.gain, default=None)
        over = float(residual[joint] / noise[joint])
        worth = best is not None and _explained(prediction, best, joint) > material * noise[joint]
        if best is not None and worth and odds_of(best, count) > least:
            probability = 1.0 / (1.0 + np.exp(-min(odds_of(best, count), 700.0)))
            rows.append(Remainder(joint, over, float(probability), best.candidate.effect))
        elif frequency := line(prediction, joint):
            rows.append(Remainder(joint, over, 1 - LINES, f"time, at {frequency:.1f} Hz"))
        elif over > (BEYOND if rested else GUESSED):
            rows.append(Remainder(joint, over, CREDIBLE, UNCERTAIN))
    return rows


def fast_ripples(runs: Sequence[Driven], noise: np.ndarray, units: Sequence[str]) -> Iterator[Remainder]:
    """Waves over position that the filter of the comparison removes, and the cut-off that shows them.

    The noise floor (n,) is that behind the filter [N m].
    """
    for joint, floor in enumerate(noise.tolist()):
        if (fast := line_above_cutoff(runs, joint)) is not None:
            waves = f"{round(fast.waves)} waves per turn, {digits(fast.amplitude, 2)} {units[joint]}"
            cure = f"to see it: --torque-cutoff {np.ceil(fast.cutoff):.0f}"
            over = fast.amplitude / np.sqrt(2.0) / floor
            yield Remainder(joint, float(over), 1 - LINES, f"position ({waves}; {cure})")


def beside_unnamed(result: SearchResult, features: list[Answer], noise: np.ndarray) -> SearchResult:
    """The result with the unnamed residual on the joint of each finding, relative to what that explains.

    A residual with a dependence counts completely. Of a residual above the noise (n,) [N m] without a
    dependence, any hypothesis would explain a part by chance: one kind of dependence among all kinds, or its
    columns among the columns of all kinds, whichever is more.
    """
    prediction, joints = result.prediction, result.prediction.joints
    dependent, columns = np.zeros(joints), np.zeros(joints)
    for feature in features:
        [joint] = feature.candidate.joints
        columns[joint] += len(feature.candidate.names)
        if odds_of(feature, joints * len(KINDS)) > CERTAIN_ODDS:
            dependent[joint] = max(dependent[joint], _explained(prediction, feature, joint) ** 2)
    above = np.maximum(rms(prediction.residual, prediction.rows.weight) ** 2 - noise**2, 0.0)
    selected = list(result.selected)
    for place, finding in enumerate(selected):
        joint = finding.answer.joint
        # A finding from other signals, or from strained nominal values, explains no blocks.
        apart = finding.once or finding.answer.relief > float(finding.answer.by_joint.sum())
        explained = 0.0 if apart else _explained(prediction, finding.answer, joint) ** 2
        if explained > 0.0:
            part = max(1.0 / len(KINDS), len(finding.answer.values) / max(columns[joint], 1.0))
            alike = max(dependent[joint], part * above[joint])
            selected[place] = finding._replace(unnamed=float(alike / explained))
    return replace(result, selected=tuple(selected)).ordered()


def _explained(prediction: Prediction, answer: Answer, joint: int) -> float:
    """Root mean square by which an answer reduces the error of a joint's predicted blocks [N m].

    The torque of the answer may be far larger, since the parameters of the model absorb most of a smooth
    function.
    """
    return float(np.sqrt(max(explained_variance(prediction, answer, joint)[1], 0.0)))


def line(prediction: Prediction, joint: int) -> float:
    """Frequency of a spectral line that two runs share in a joint's residual [Hz]; zero without a line.

    A vibration appears in every run; a line in one run alone comes from a swept sine. The residual is not
    whitened, since whitening removes lines.
    """
    counts, residual = prediction.rows.weight[:, joint] > 0, prediction.residual[:, joint]
    runs = [residual[rows][counts[rows]] for rows in prediction.rows.runs]
    runs = [moving for moving in runs if len(moving) >= FEWEST]
    if not runs:
        return 0.0
    # Runs of different lengths are compared frequency by frequency.
    lengths = [len(moving) for moving in runs]
    length = 2 ** int(np.ceil(np.log2(2 * max(lengths))))
    spectra = [np.abs(np.fft.rfft(moving * np.hanning(len(moving)), length)) ** 2 for moving in runs]
    lowest = int(SLOWEST * length / prediction.rate)
    # Above `PASSED`, the filter has removed the torque.
    inner = np.array(spectra)[:, lowest : int(PASSED * len(spectra[0]))]
    place = spectral_line(inner, max(length // min(lengths), 1))
    return 0.0 if place is None else float((place + lowest) * prediction.rate / length)


def rms(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted root mean square over rows (r, n), shape (n,)."""
    return np.sqrt(np.sum(values**2 * weight, axis=0) / np.maximum(weight.sum(axis=0), 1.0))
