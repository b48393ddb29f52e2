"""Runs with a payload as a command line gives them, and the names of their bodies."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from exidyn.identify.effects import known_parameters
from exidyn.identify.errors import NeedsPayload
from exidyn.identify.recordings.recording import KnownPayload, Recording

from ..arguments.command import Option, any_number


@dataclass
class PayloadRun:
    """One --payload and the numbers that followed it.

    Attributes:
        path: The run.
        numbers: "mass" [kg], "com" [m] and "inertia" [kg m^2], as `known_parameters` takes them.
    """

    path: Path
    numbers: dict[str, Any] = field(default_factory=dict)

    def known(self) -> tuple[tuple[str, float], ...]:
        """What is known of the body; empty without numbers.

        Raises:
            NeedsPayload: A centre of mass or inertia without mass.
        """
        if not self.numbers:
            return ()
        if "mass" not in self.numbers:
            raise NeedsPayload(
                f"--payload {self.path}: {' and '.join(self.numbers)} given without --mass [kg]"
            )
        return known_parameters(**self.numbers)


class OfLastPayload(argparse.Action):
    """--mass, --com, --inertia: belong to the last --payload."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the number to the run."""
        if not namespace.payload:
            parser.error(f"{option_string} belongs behind the --payload whose body it describes")
        name = str(option_string).lstrip("-")
        numbers = namespace.payload[-1].numbers
        if name in numbers:
            parser.error(f"--payload {namespace.payload[-1].path} has {option_string} twice")
        numbers[name] = values


PAYLOADS = (
    Option(
        "--payload RUN",
        "run with a body on the flange; may be repeated, each with its own --mass",
        lambda path: PayloadRun(Path(path)),
        [],
        repeated=True,
    ),
    Option("--mass KG", "mass of that body [kg]", any_number, dest="payload", action=OfLastPayload),
    Option(
        "--com X Y Z",
        "its centre of mass in the flange's frame [m]",
        any_number,
        dest="payload",
        action=OfLastPayload,
    ),
    Option(
        "--inertia XX XY XZ YY YZ ZZ",
        "its inertia about the centre of mass, in the flange's axes [kg m^2]",
        any_number,
        dest="payload",
        action=OfLastPayload,
    ),
)
"""Runs with a payload, and what may follow each."""


def carrying(recording: Recording, run: PayloadRun) -> Recording:
    """The recording with the body of the command line, or with the one that it brings.

    Raises:
        NeedsPayload: Nothing is known of the body.
    """
    known = run.known()
    if known:
        name = recording.payload.name if recording.payload else "L"
        return replace(recording, payload=KnownPayload(name, known))
    if recording.payload is None or not recording.payload.known:
        raise NeedsPayload(
            f"--payload {run.path}: neither the file nor the command line gives the mass of the payload. Add "
            "--mass KG behind it; if it is not known, give the file as a further RUN without --payload"
        )
    return recording


def distinct_bodies(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings with one name a body: bodies of which different things are known get different names."""
    names: dict[tuple, str] = {}
    named = []
    for recording in recordings:
        if recording.payload is not None:
            body = recording.payload.name, recording.payload.known
            if body not in names:
                names[body] = _free(body[0], set(names.values()))
            recording = replace(recording, payload=KnownPayload(names[body], body[1]))
        named.append(recording)
    return named


def _free(name: str, taken: set[str]) -> str:
    """The name, or the name with the first number from 2 that makes it a new one."""
    numbered = (f"{name}{number}" for number in range(2, len(taken) + 3))
    return name if name not in taken else next(n for n in numbered if n not in taken)
