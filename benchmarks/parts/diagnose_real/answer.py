"""One diagnosis of a real arm, once more with what was named in its model, and what is known of that arm."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.family import FAMILIES, Family
from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.diagnosis.improved.improved import found_model, left_out
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model

from ..concealed.scoring import dependence
from ..proof.open_loop import open_loop
from .known import Known, numbers
from .sets import CASES, Case, Runs

DERIVED = {"amplitude": "N m", "gear stiffness": "N m/rad", "harmonic": "1"}
"""Units of numbers that follow from others."""
STUCK = 1e-9
"""Standard deviation of a number that its limit holds, at most, as a part of the number or of one [-]."""


def size(one: Finding) -> str:
    """Coefficients and shape of a finding that are determined, with one standard deviation.

    Where some are not, what no other parameter can take over of its torque, root mean square.
    """
    units = {name: q.unit for name, q in one.parameters.items()} | DERIVED
    stated = {name: pair for name, pair in numbers(one).items() if name in units and name not in one.left_out}
    words = [number(name, *pair, units[name]) for name, pair in stated.items()]
    if one.left_out and one.size is not None:
        words.append(number("torque", one.size.beside_rms, one.size.beside_std, "N m"))
    return ", ".join(words)


def number(name: str, value: float, std: float, unit: str) -> str:
    """One number; of what is at a limit of its range the deviation says nothing."""
    unit = "" if unit == "1" else f" {unit}"
    if std < STUCK * max(abs(value), 1.0):
        return f"{name} {value:.4g}{unit} (at its limit, not measured)"
    return f"{name} {value:.4g}{f' ± {std:.2g}' if np.isfinite(std) else ''}{unit}"


def joints_words(joints: Sequence[int]) -> str:
    """J2 J3; a dash for the whole arm."""
    return " ".join(f"J{joint + 1}" for joint in joints) or "-"


def shown(known: Known, model: Model, runs: Runs) -> str:
    """Residual held out of the joint without and with the effect, per run; nothing if no fit shows it."""
    if known.term is None:
        return ""
    joint = known.joints[0]
    with_it = model + known.term(model.robot.joints[joint])
    before, after = (held_out(one, runs, joint) for one in (model, with_it))
    unit = model.robot.unit(joint, "N m")
    change = 100 * (np.linalg.norm(after) / np.linalg.norm(before) - 1)
    lists = " → ".join(", ".join(f"{value:.3g}" for value in some) for some in (before, after))
    return f"residual held out without and with it: {lists} {unit} ({change:+.0f} %)"


def held_out(model: Model, runs: Runs, joint: int) -> np.ndarray:
    """Root mean square of a joint's residual in each run held out in which it moves, driven (h,)."""
    fitted = [run for role, run in runs if role != HELD_OUT]
    fit = identify(fitted, [run for role, run in runs if role == HELD_OUT], model=model)
    slides = [one for one in fit.validation if one.weight[:, joint].any()]
    return np.array([one.residual_rms[joint] for one in slides])


def again(case: Case, runs: Runs, found: Diagnosis) -> dict[str, Any]:
    """What is named with found.toml for a model, and which of that no model holds.

    As in found.toml, what is undecided is held too.
    """
    model = found_model(found)
    if model is None or not (found.findings or found.undecided):
        return {"held": 0, "lost": [], "named": [], "repeated": []}
    lost = [found.all_findings[place].effect for place in left_out(found)]
    second = diagnose(model, runs, case.title, case.filtering)
    return {
        "held": len(found.findings) + len(found.undecided) - len(lost),
        "lost": lost,
        "named": [words(one) for one in second.findings],
        "repeated": [words(one) for one in second.findings if repeats(one, found, lost)],
    }


def repeats(one: Finding, found: Diagnosis, lost: list[str]) -> bool:
    """Whether it was named before, and no model could hold it."""
    before = [(other.effect, other.joints) for other in found.findings]
    return one.effect in lost and (one.effect, one.joints) in before


def words(one: Finding) -> str:
    """A finding in one line."""
    return f"{one.effect} {joints_words(one.joints)}, {one.probability:.3f}: {size(one)}"


@dataclass(frozen=True)
class Named:
    """One finding."""

    effect: str  # Name in the vocabulary
    joints: str  # Names of where it acts
    probability: float  # Stated
    size: str  # Its numbers, in words
    verdict: str  # "known", "false" or "unverified"; "undecided" where it was not named
    why: str = ""  # Why it is false; what it might be instead where it is undecided
    instead: float = 0.0  # Probability of the most credible other name where it is undecided


def answer(key: str, twice: bool = True) -> dict[str, Any]:
    """Diagnose a set; with its own findings put into the model, once more.

    Returns:
        What is printed, written as JSON and drawn.
    """
    case = CASES[key]
    model, runs = case.ask()
    clock, used = time.monotonic(), time.process_time()
    found = diagnose(model, runs, key, case.filtering)
    clock, used = time.monotonic() - clock, time.process_time() - used
    return {
        "case": key,
        "known": [compared(known, found) | {"shown": shown(known, model, runs)} for known in case.known],
        "named": [asdict(named(case, one, found.findings)) for one in found.findings],
        "undecided": [asdict(undecided(one)) for one in found.undecided],
        "again": again(case, runs, found) if twice else None,
        "left": [
            f"J{one.joint + 1} {one.over_noise:.1f} x noise, depends on {one.depends_on}"
            for one in found.remainders
        ],
        "moments": [
            f"{m.run} {m.start:.1f} s, {joints_words(m.joints)}, {m.force:.3g} N" for m in found.moments
        ],
        "band": found.torque_rms_filter_hz,
        "improvement": improvement(found),
        "budget": budget(found),
        "warnings": list(found.warnings),
        "seconds": clock,
        "process_seconds": used,
        "data_seconds": sum(run.duration for _, run in runs),
        "joints": len(found.joints),
        "open_loop": open_loop(found, runs) if key == "emps" else None,
    }


def compared(known: Known, found: Diagnosis) -> dict[str, Any]:
    """A known effect and the finding that is it, or how near one came."""
    fields = {name: getattr(known, name) for name in ("effect", "how", "size", "expected")}
    one, fields = known.is_in(found.findings), fields | {"joints": joints_words(known.joints)}
    fields["by_family"] = one is not None or by_family(known, found)
    if one is None:
        return fields | {"named": False, "near": near(known, found)}
    return fields | {
        "named": True,
        "found": size(one),
        "probability": one.probability,
        "right": known.right(one),
    }


def by_family(known: Known, found: Diagnosis) -> bool:
    """Whether a finding on the joints of a known effect names what that depends on."""
    depends_on = dependence(known.effect)
    families = [(one.joints, one.family or dependence(one.effect)) for one in found.findings]
    families += [(one.joints, one.family) for one in found.undecided if one.family]
    return any(
        joints == known.joints and FAMILIES.get(name, Family(name, "")).dependence == depends_on
        for joints, name in families
    )


def named(case: Case, one: Finding, every: Sequence[Finding]) -> Named:
    """A finding of several, and whether it is known to be there, known not to be, or neither."""
    verdict, why = "unverified", ""
    if case.control:
        verdict, why = "false", "nothing is missing on this set"
    elif any(known.is_in(every) is one for known in case.known):  # a second one of it is not known
        verdict = "known"
    elif one.effect in case.absent:
        verdict, why = "false", case.absent[one.effect]
    return Named(one.effect, joints_words(one.joints), one.probability, size(one), verdict, why)


def undecided(one: Finding) -> Named:
    """A finding without a certain name."""
    others = [f"{o.effect} {joints_words(o.joints)} {o.probability:.2f}" for o in one.alternatives[:3]]
    instead = max((other.probability for other in one.alternatives), default=0.0)
    why = ", ".join(others)
    return Named(one.effect, joints_words(one.joints), one.probability, size(one), "undecided", why, instead)


def near(known: Known, found: Diagnosis) -> str:
    """How near an effect that is not named was to it."""
    for one in found.undecided:
        for other in (one, *one.alternatives):
            if (other.effect, other.joints) == (known.effect, known.joints):
                return f"undecided, probability {other.probability:.2f}"
    return "not among what it may be"


def improvement(found: Diagnosis) -> dict[str, Any] | None:
    """Residual of runs held out per joint [N m]."""
    if found.torque_rms_before is None or found.torque_rms_after is None:
        return None
    before, after, noise = found.torque_rms_before, found.torque_rms_after, found.noise
    return {"before": before.tolist(), "after": after.tolist(), "noise": noise.tolist()}


def budget(found: Diagnosis) -> dict[str, Any] | None:
    """Shares of the misfit per joint, by words."""
    if found.budget is None:
        return None
    every = (*found.findings, *found.undecided)
    shares = []
    for one in found.budget.shares:
        what = one.kind or f"{every[one.finding].effect} {joints_words(every[one.finding].joints)}"
        what = what.removesuffix(" -")  # of the whole arm
        part = (
            "kind" if one.finding is None else "named" if one.finding < len(found.findings) else "undecided"
        )
        shares.append({"what": what, "part": part, "shares": (one.percent / 100.0).tolist()})
    return {
        "before": found.budget.before_rms.tolist(),
        "after": found.budget.after_rms.tolist(),
        "shares": shares,
    }
