"""The payload of `exidyn example`: 175 kg on a simulated KR270 whose stated drive gains are 10 % too large.

Its commands plan and record the runs, as a user would; the payload is then weighed without its stated mass.
"""

import contextlib
import io
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from exidyn.acquire.command_line import main
from exidyn.acquire.examples import example_gains
from exidyn.acquire.examples.example_arm import MASS
from exidyn.identification.fit.identification import identify
from exidyn.identification.payload.payload_estimate import DESCRIPTION, DIFFERENCE, FIT
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording

from .real import score

SECONDS = 20.0
"""Duration of the motion: what the aim allows for weighing [s]."""
RECORDED = ("unloaded", "loaded")


@cache
def runs() -> tuple[Recording, Recording]:
    """The run without the payload, and the one with it, whose stated payload is removed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        example_gains.arm().write(folder)
        for step in example_gains.steps(folder, SECONDS, None):
            output = Path(step.arguments[step.arguments.index("--output") + 1])
            if output.stem in ("trajectory", *RECORDED):
                with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                    if code := main([step.command, *step.arguments]):
                        raise RuntimeError(f"{step}: exit code {code}")
        empty, loaded = (import_source(folder / f"{name}.mcap", None)[0] for name in RECORDED)
    return empty, replace(loaded, payload=None)


def example_cases() -> dict[str, Callable[[], dict[str, Any]]]:
    """Name -> function that identifies the payload."""
    return {
        f"KR270 example, {MASS:g} kg, {way}": lambda w=way: weighed(w)
        for way in (FIT, DIFFERENCE, DESCRIPTION)
    }


def weighed(way: str) -> dict[str, Any]:
    """The payload, by what is known of the arm."""
    empty, loaded = runs()
    if way == FIT:
        return score(weigh([loaded], fit=identify([empty])), MASS)
    return score(weigh([loaded], empty=[empty] if way == DIFFERENCE else []), MASS)
