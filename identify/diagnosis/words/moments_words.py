"""Moments: when a run differs from the model as at no other time, in words and for files."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...text_table import digits
from ..findings.finding import Moment
from .naming import joined
from .numbers import array_of, number, numbers, value_of


def sentence(moment: Moment) -> str:
    """One moment, with a full stop."""
    count = [str(joint + 1) for joint in moment.joints]
    where = f"joint {count[0]} differs" if len(count) == 1 else f"joints {joined(count)} differ"
    return f"{moment.run}, {span(moment)}: {where} from the model as at no other time{_force(moment)}."


def span(moment: Moment) -> str:
    """From when to when, by the run's time."""
    return f"{moment.start:.2f} to {moment.end:.2f} s"


def direction(moment: Moment) -> str:
    """Of the force on the flange, in the base's axes; "-" where there is none."""
    if not np.isfinite(moment.force):
        return "-"
    return "({:.2f}, {:.2f}, {:.2f})".format(*(moment.direction + 0.0))


def size(moment: Moment) -> str:
    """Of that force."""
    return f"{digits(moment.force)} N" if np.isfinite(moment.force) else "-"


def _force(moment: Moment) -> str:
    if not (np.isfinite(moment.force) and moment.force > 0.0):
        return ""
    return (
        f", as if a force of {moment.force:.2g} N acted on the flange along {direction(moment)} "
        "in the base's axes"
    )


def as_table(moments: Sequence[Moment]) -> list[dict[str, Any]]:
    """For diagnosis.json, joints from 1."""
    return [
        {
            "run": one.run,
            "start": number(one.start),
            "end": number(one.end),
            "joints": [joint + 1 for joint in one.joints],
            "direction": numbers(one.direction),
            "force": number(one.force),
        }
        for one in moments
    ]


def from_table(rows: Sequence[dict[str, Any]]) -> tuple[Moment, ...]:
    """Read them back, of a table of the schema `DiagnosisFile`."""
    return tuple(
        Moment(
            one["run"],
            value_of(one["start"]),
            value_of(one["end"]),
            tuple(joint - 1 for joint in one["joints"]),
            array_of(one["direction"]),
            value_of(one["force"]),
        )
        for one in rows
    )
