"""The product's check of recordings. No other file of this benchmark imports it."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from exidyn.identification.model import Model
from exidyn.identification.plausible.gate import doubts, suspect
from exidyn.identification.recordings.recording import Recording


class Claim(NamedTuple):
    """What the check says about recordings.

    Attributes:
        text: The sentence that a person reads.
        probability: Stated probability of that sentence.
        refuses: Whether identify refuses the recordings because of it.
    """

    text: str
    probability: float
    refuses: bool


PRINTED = re.compile(r"(\S.{0,300}?) \(probability (?:>|above)? ?([\d.]+) %\)")
"""How a statement with its probability is printed."""
AS_RECORDED = "--as-recorded"
"""Stands in every refusal by the check, which this option takes back."""


def claims_in(text: str) -> list[Claim]:
    """All statements with a probability that a command printed on standard error, each once."""
    claims = {}
    for line in text.splitlines():
        for sentence, percent in PRINTED.findall(line):
            sentence = sentence.removeprefix("warning: ").removeprefix("exidyn: ")
            claims[sentence] = Claim(
                f"{sentence} {line[line.find(sentence) :]}", float(percent) / 100, AS_RECORDED in line
            )
    return list(claims.values())


def claims_about(runs: Sequence[Recording], model: Model) -> list[Claim]:
    """All statements of the check about recordings of one arm."""
    suspicion = suspect(runs, model)
    if suspicion is None or suspicion.probability is None:
        return []
    return [Claim(str(suspicion), suspicion.probability, False)]


def check_before_fit(runs: Sequence[Recording], model: Model) -> None:
    """The whole check that identify makes before it fits."""
    doubts(runs, model)
