"""Schema of choice.json, which a study reads from its earlier rounds."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

from msgspec import Meta, Struct

from exidyn.identification.errors import NotAFile
from exidyn.identification.schema import (
    EffectName,
    JointNumber,
    Name,
    Number,
    Size,
    SizeOrNull,
    check,
    check_joints,
)
from exidyn.trajectories.next_run.choice import DECIDED, OUT_OF_TIME, RUN, UNDECIDABLE

VERDICTS = (RUN, DECIDED, UNDECIDABLE, OUT_OF_TIME)
Sentence = Annotated[str, Meta(max_length=10_000)]
Duration = Annotated[float, Meta(gt=0.0, le=1e9)]
"""Duration of a run [s], at most thirty years."""
Finding = tuple[EffectName, list[JointNumber]]
"""Effect and numbers of its joints, from 1."""
Shape = tuple[EffectName, list[JointNumber], str, dict[str, Number]]
"""Effect, numbers of its joints, from 1, kind, and shape parameters by name."""


class ItemRow(Struct, frozen=True):
    """A question: its words, entropy [bit], whether it is open, and whether an available run settles it."""

    words: Sentence
    entropy: Size
    open: bool
    decidable: bool


class OfferRow(Struct, frozen=True):
    """An available run: its durations [s], what a person has to do, and the expected information [bit]."""

    name: Name
    motion: Annotated[float, Meta(ge=0.0, le=1e9)]
    seconds: Duration
    request: Sentence
    gained: Number


class Chosen(Struct, frozen=True, forbid_unknown_fields=True):
    """The chosen run: the file of its motion and what it needs, or the name of an existing recording."""

    plan: Name | None = None
    loaded: bool = False
    request: Sentence = ""
    recording: Name | None = None

    def __post_init__(self) -> None:
        check((self.plan is None) != (self.recording is None), "plan", self.plan, "a plan or a recording")
        path = PurePosixPath(self.plan or "")
        inside = not path.is_absolute() and ".." not in path.parts
        check(inside, "plan", self.plan, "a path below the folder of the study")


class ChoiceFile(Struct, frozen=True):
    """The file; its other keys are for human readers."""

    verdict: str
    believed: list[Sentence]
    findings: list[Finding]
    left_over_noise: dict[str, SizeOrNull]
    entropy: Size
    items: list[ItemRow]
    offers: list[OfferRow]
    remains: list[Sentence]
    moved: Size
    asked: dict[str, Any]
    chosen: Chosen | None
    shapes: list[Shape] = []

    def __post_init__(self) -> None:
        check(self.verdict in VERDICTS, "verdict", self.verdict, f"one of {', '.join(VERDICTS)}")
        continues = self.verdict == RUN
        check(bool(self.offers) or not continues, "offers", self.offers, f"a run, as the verdict is {RUN}")
        check(
            (self.chosen is not None) == continues, "chosen", self.chosen, f"a run where the verdict is {RUN}"
        )
        for place, (_, joints, *_) in enumerate(self.shapes):
            check_joints(joints, f"shapes[{place}][1]", len(self.left_over_noise))


def require_course(folder: Path, choices: Sequence[tuple[str, Mapping[str, Any]]]) -> None:
    """Refuse rounds that cannot belong to one study.

    Args:
        folder: Folder of the study.
        choices: Name and choice of each round.

    Raises:
        NotAFile: If a round follows one that ended the study, or two rounds have different joints.
    """
    for (name, choice), (following, later) in pairwise(choices):
        if choice["verdict"] != RUN:
            raise NotAFile(
                f"{folder}: {name} ended the study, but {following} follows it; remove {following}"
            )
        if list(choice["left_over_noise"]) != list(later["left_over_noise"]):
            raise NotAFile(f"{folder}: {name} and {following} have different joints; remove {following}")
