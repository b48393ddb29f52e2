"""Limits of a diagnosis: warnings, each as one sentence, without repetition."""

from collections.abc import Iterator, Sequence

from ...plausible.suspicion import CHECK_FIRST
from ...text_table import digits, percent
from ..findings.beliefs import Beliefs, Departure
from ..findings.diagnosis import Diagnosis
from ..findings.evidence import UNCERTAIN
from .importance import clearest_joint
from .naming import capital, joined, joint_words, joints_words, lower, named
from .sentences import moment_sentence

MOST_NAMED = 2
"""Number of parameters that a sentence names; pages list all of them."""


def warnings(diagnosis: Diagnosis, said: Sequence[str] = ()) -> list[str]:
    """What limits the result, the most important first; without sentences that were already said."""
    runs = (*diagnosis.runs, *diagnosis.held_out)
    lines = [
        *suspicion_sentences(diagnosis),
        *_of_beliefs(diagnosis),
        *map(moment_sentence, diagnosis.moments),
    ]
    if joints := [each.joint for each in diagnosis.remainders if each.depends_on == UNCERTAIN]:
        lines.append(f"an unexplained residual remains on {joints_words(joints, diagnosis.joints)}")
    sentences = dict.fromkeys(full(line, runs) for line in (*lines, *diagnosis.warnings))
    return [line for line in sentences if not any(line in other for other in said)]


def suspicion_sentences(diagnosis: Diagnosis) -> list[str]:
    """Sentences on suspected mistakes in the input."""
    runs = (*diagnosis.runs, *diagnosis.held_out)
    return [f"{CHECK_FIRST}: {full(suspicion, runs)}" for suspicion in diagnosis.suspicions]


def full(words: str, runs: Sequence[str]) -> str:
    """The words as a sentence; the name of a run at the beginning is not capitalized."""
    text = words if words.startswith(tuple(runs)) else capital(words)
    return text + ("" if words.endswith((".", "!", "?")) else ".")


def _of_beliefs(diagnosis: Diagnosis) -> Iterator[str]:
    """Where the two beliefs about the bodies differ, and the parameters that leave their tolerances."""
    if (beliefs := diagnosis.beliefs) is None:
        return
    if beliefs.conditional:
        yield _conflict(diagnosis, beliefs)
    yield from (departure_sentence(diagnosis, departure) for departure in beliefs.departures)


def _conflict(diagnosis: Diagnosis, beliefs: Beliefs) -> str:
    """Sentence on findings that free bodies absorb, and on what these bodies are then."""
    findings = [diagnosis.all_findings[place] for place in beliefs.conditional]
    names = joined([lower(named(f.effect, f.joints, diagnosis.joints)) for f in findings])
    joint = clearest_joint(diagnosis, findings[0])
    described, free = (digits(rms[joint], 3) for rms in (beliefs.described_rms, beliefs.free_rms))
    off = [f"{_parameter(each)} by {digits(each.deviations, 2)}" for each in beliefs.absorbed_by]
    bodies = f"{joined(off[:MOST_NAMED])} standard deviations off the description" if off else "other bodies"
    where = lower(joint_words(joint, diagnosis.joints))
    return (
        f"Free bodies absorb {names}, with {bodies}; residual of {where}: {free} instead of {described} "
        f"{diagnosis.torque_units[joint]}."
    )


def departure_sentence(diagnosis: Diagnosis, departure: Departure) -> str:
    """Sentence on a parameter that leaves its stated tolerance."""
    of_link = departure.group == "link"
    where = (
        f"link {departure.joint + 1}" if of_link else lower(joint_words(departure.joint, diagnosis.joints))
    )
    value, nominal = departure.value, departure.nominal
    size = f"{digits(value, 3)} instead of {digits(nominal, 3)} {departure.unit}"
    if nominal:
        side = "above" if (value - nominal) * nominal > 0.0 else "below"
        size = f"{percent(abs(value / nominal - 1.0), 3)} {side} its nominal value"
    return (
        f"The {_parameter(departure)} of {where} is {size}: {digits(departure.deviations, 2)} of its stated "
        "standard deviations."
    )


def _parameter(departure: Departure) -> str:
    """A parameter in words, such as "first moment MX2"."""
    if departure.group != "link":
        return {"rotor": "rotor inertia"}.get(departure.group, departure.group)
    letters = departure.parameter.rstrip("0123456789")
    kind = "mass" if letters == "M" else "first moment" if letters.startswith("M") else "inertia"
    return f"{kind} {departure.parameter}"
