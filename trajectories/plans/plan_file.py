"""Trajectory files: the one module of `trajectories` that reads and writes files."""

import os
from pathlib import Path

from ..errors import NotATrajectory
from .plan import Plan
from .plan_text import parse_plan, plan_text

__all__ = ["parse_plan", "plan_text", "read_plan", "write_plan"]


def write_plan(plan: Plan, path: Path | str) -> None:
    """Write a trajectory file; it appears under its name only when it is whole."""
    part = Path(path).with_name(Path(path).name + ".part")
    part.write_text(plan_text(plan), encoding="utf-8")
    os.replace(part, path)


def read_plan(path: Path | str) -> Plan:
    """Plan from a trajectory file.

    Raises:
        NotATrajectory: Missing, cut off, of a later version, or wrong; the message names the place.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NotATrajectory(
            f"{path}: not a text file (UTF-8); expected a trajectory file (.toml)"
        ) from error
    except OSError as error:
        raise NotATrajectory(f"{path}: cannot be read: {error.strerror}") from error
    return parse_plan(text, str(path))
