"""Effects added to real recordings: are they named, and are stated probabilities right?

Each set is diagnosed as it is, which is the background; then an effect that neither it nor its alternatives
have is added to the measured torque, of such a size that what no nominal parameter explains of it is so many
times what plain least squares leave on that joint. What is named beyond the background is right or false.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: times are those of one core

import numpy as np
from common import parser, save, show
from parts.diagnose_real.sets import CASES, FOLDER, Case, of_set
from parts.injected import EFFECTS, Added, Background, effort
from parts.real.data import UR10E

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.recordings.recording import Recording, Signal

STRENGTHS = (0.5, 1.0, 2.0)
"""What no nominal parameter explains of an effect, over what least squares leave without it [-]."""
SEEN = 0.3
"""The same of an effect that has the size that it has, at least [-]."""
WEAKEST = 1e-9
"""Visibility below which an effect is nominal [-]: rounding."""
TRIES = 50
"""Draws until an effect can be on a joint."""
SETS = ("emps", "tx40", "panda", "kr300", "ur10e", "kscale", "odrive_off", "odrive_on")
QUICK = ("emps", "kscale")
LIMITS = (0.5, 0.8, 0.9, 0.95, 0.99)
"""Ends of the classes of stated probability."""


def background(key: str) -> tuple[Case, Background]:
    """A set and its runs; of the UR10e three runs, so that a case takes seconds."""
    case = CASES[key]
    if key == "ur10e":
        return case, Background(*of_set(UR10E, UR10E.train[:2], UR10E.held_out[:1]))
    return case, Background(*case.ask())


def with_torque(ground: Background, torques: Sequence[np.ndarray]) -> list[tuple[str, Recording]]:
    """The runs with torque (t, n) [N m] added to what was measured."""
    runs = []
    for (role, run), motion, torque in zip(ground.runs, ground.motions, torques, strict=True):
        name = effort(run)
        old = run.signals[name]
        units = torque / ground.per_unit(run)
        more = np.stack([np.interp(old.time, motion.time, column) for column in units.T], axis=1)
        signals = {**run.signals, name: Signal(old.time, old.values + more)}
        runs.append((role, replace(run, signals=signals)))
    return runs


def names(found: Diagnosis, undecided: bool = False) -> dict[tuple[str, tuple[int, ...]], float]:
    """Effect and joints of what is named -> probability; with what it may be where that is asked for."""
    every = {(one.effect, tuple(one.joints)): float(one.probability) for one in found.findings}
    if undecided:
        for one in found.undecided:
            for other in (one, *one.alternatives):
                every.setdefault((other.effect, tuple(other.joints)), float(other.probability))
    return every


def drawn(
    ground: Background, taken: Any, rng: np.random.Generator
) -> tuple[str, Added, float, list[np.ndarray]] | None:
    """An effect on a joint that does not have it, its strength and its torque."""
    for _ in range(TRIES):
        name, joint = str(rng.choice(list(EFFECTS))), int(rng.integers(ground.model.robot.dof))
        added = EFFECTS[name](ground, joint, rng)
        if added is None or (name, added.joints) in taken:
            continue
        unit = ground.visible(added.torques)
        strength = unit if added.sized else float(rng.choice(STRENGTHS))
        size = strength / max(unit, WEAKEST)
        torques = [size * torque for torque in added.torques] if size < added.largest else []
        if torques and strength > SEEN and _share(ground, torques) < added.most:
            return name, added, strength, torques
    return None


def _share(ground: Background, torques: Sequence[np.ndarray]) -> float:
    own, usual = (np.concatenate(list(some)).std(axis=0) for some in (torques, ground.torques))
    return float(np.max(own / usual))


def answers(key: str, count: int, seed: int) -> Iterator[dict[str, Any]]:
    """One line a case of a set."""
    case, ground = background(key)
    before = diagnose(ground.model, ground.runs, key, case.filtering)
    taken, named = names(before, undecided=True), names(before)
    for number in range(count):
        rng = np.random.default_rng([seed, SETS.index(key), number])
        one = drawn(ground, taken, rng)
        if one is None:
            continue
        effect, added, strength, torques = one
        found = diagnose(ground.model, with_torque(ground, torques), key, case.filtering)
        said, truth = names(found), (effect, added.joints)
        more = {name: p for name, p in said.items() if name not in taken}
        open_ = names(found, undecided=True)
        yield {
            "set": key,
            "number": number,
            "effect": effect,
            "joints": added.joints,
            "strength": strength,
            "share": _share(ground, torques),
            "named": truth in said,
            "probability": open_.get(truth, 0.0),
            "false": [[*name, p] for name, p in more.items() if name != truth],
            "lost": [list(name) for name in named if name not in said],
            "open": [[*name, p] for name, p in open_.items() if name not in taken and name not in said],
        }


def score(lines: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The figures."""
    stated = [(p, False) for one in lines for *_, p in one["false"]]
    stated += [(one["probability"], True) for one in lines if one["named"]]
    stated += [
        (p, (e, tuple(j)) == (one["effect"], tuple(one["joints"])))
        for one in lines
        for e, j, p in one["open"]
    ]
    classes = []
    for low, high in zip((0.0, *LIMITS), (*LIMITS, 1.01), strict=True):
        inside = [(p, right) for p, right in stated if low <= p < high]
        if inside:
            means = [float(np.mean(column)) for column in zip(*inside, strict=True)]
            classes.append([low, min(high, 1.0), len(inside), *means])
    return {
        "cases": len(lines),
        "named_percent": 100.0 * float(np.mean([one["named"] for one in lines])),
        "false_names": sum(len(one["false"]) for one in lines),
        "cases_with_false_name": sum(bool(one["false"]) for one in lines),
        "lost": sum(len(one["lost"]) for one in lines),
        "calibration": classes,
    }


def report(lines: Sequence[dict[str, Any]]) -> None:
    """Tables by set, effect and strength, and of stated probabilities."""
    for by in ("set", "effect", "strength"):
        rows = []
        for value in dict.fromkeys(sorted(one[by] for one in lines)):
            own = [one for one in lines if one[by] == value]
            counts = [sum(bool(one[what]) for one in own) for what in ("named", "false", "lost")]
            rows.append([str(value), len(own), *counts])
        show(f"By {by}", [by, "cases", "named", "with a false name", "with a name lost"], rows)
    figures = score(lines)
    show(
        "Stated probability, beyond the background",
        ["from", "to", "names", "stated", "right"],
        figures.pop("calibration"),
    )
    show("Score", ["figure", "value"], [[name, value] for name, value in figures.items()])


def main() -> None:
    options = parser(__doc__.splitlines()[0], SETS)
    options.add_argument("--cases", type=int, default=12, metavar="N", help="effects added to each set")
    options.add_argument("--seed", type=int, default=1, help="of the draws")
    chosen = options.parse_args()
    keys = chosen.only or (QUICK if chosen.quick else SETS)
    count = 2 if chosen.quick else chosen.cases
    lines = []
    for key in keys:
        if not (FOLDER / CASES[key].folder).is_dir():
            print(f"left out: {key}: no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
            continue
        lines += answers(key, count, chosen.seed)
    if lines:
        report(lines)
        save(chosen.json, score(lines) | {"lines": lines})


if __name__ == "__main__":
    main()
