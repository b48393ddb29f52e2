"""Figures of all diagnoses: every row shown counts."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.search.selected import NAMED

Answer = dict[str, Any]

WORSE = 1.02
"""Residual held out, after over before, from which a joint counts as worse: less is chance."""
ARM = 6
"""Joints of the sets whose time is stated."""
WORDS = {
    (True, True): "named",
    (True, None): "named",
    (True, False): "named, SIZE OFF",
    (False, None): "MISSED",
}
"""Whether a known effect is named, and whether its size is right -> in a table."""


def score(answers: Sequence[Answer]) -> dict[str, Any]:
    """The figures, by name."""
    known = [known for one in answers for known in one["known"]]
    named = [one["named"] for one in known if one["expected"]]
    families = [one["by_family"] for one in known if one["expected"]]
    verdicts = [name["verdict"] for one in answers for name in one["named"]]
    return {
        "sets": len(answers),
        "known": len(named),
        "known_named": sum(named),
        "known_named_percent": 100.0 * sum(named) / max(len(named), 1),
        "known_family_percent": 100.0 * sum(families) / max(len(families), 1),
        "sizes_off": sum(one.get("right") is False for one in known),
        **coverage(known),
        "names": len(verdicts),
        "false_names": verdicts.count("false"),
        "unverified": verdicts.count("unverified"),
        "named_otherwise": sum(n["instead"] >= NAMED for one in answers for n in one["undecided"]),
        "worse_held_out": sum(len(worse(one)) for one in answers),
        **fixed_points(answers),
        **cost(answers),
    }


def coverage(known: Sequence[Answer]) -> dict[str, Any]:
    """Named effects whose size is known, and how many of their intervals contain it [%]."""
    right = [one["right"] for one in known if one.get("right") is not None]
    return {
        "known_sizes": len(right),
        "interval_coverage": 100.0 * sum(right) / len(right) if right else None,
    }


def worse(one: Answer) -> list[int]:
    """Joints, from 0, whose residual held out is larger after than before."""
    if not one["improvement"]:
        return []
    before, after = (np.array(one["improvement"][key]) for key in ("before", "after"))
    return np.flatnonzero(after > WORSE * before).tolist()


def fixed_points(answers: Sequence[Answer]) -> dict[str, Any]:
    """On how many sets a second diagnosis names nothing; and nothing but what no model holds."""
    asked = [one for one in answers if one["again"]]
    return {
        "asked_again": len(asked),
        "fixed_point": bool(asked) and all(map(fixed, asked)),
        "at_fixed_point": sum(map(fixed, asked)),
        "at_fixed_point_but_for_what_no_model_holds": sum(
            len(one["again"]["named"]) == len(one["again"]["repeated"]) for one in asked
        ),
    }


def fixed(one: Answer) -> bool:
    """Whether nothing is named when it is diagnosed again."""
    return not one["again"]["named"]


def cost(answers: Sequence[Answer]) -> dict[str, Any]:
    """Processor time a minute of data, the largest of arms, and of which; the longest diagnosis [s]."""
    arms = {
        one["case"]: 60.0 * one["process_seconds"] / one["data_seconds"]
        for one in answers
        if one["joints"] == ARM
    }
    slowest = max(arms, key=lambda key: arms[key], default=None)
    return {
        "cpu_seconds_per_minute": arms[slowest] if slowest else None,
        "cpu_seconds_per_minute_set": slowest,
        "seconds": max((one["seconds"] for one in answers), default=0.0),
        "process_seconds": max((one["process_seconds"] for one in answers), default=0.0),
    }
