"""Options with which a log that is refused can be imported. Each is tried before it is suggested."""

from collections.abc import Callable, Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..errors import BadTime, BadUnit, RecordingError
from ..model import Model
from .recording import Recording
from .recording_checks import BEYOND_LIMITS, beyond_limits

SHORTEST = 1.0
"""Minimum duration of a run in another unit of time [s]; a few poses in milliseconds are no run."""
FEWEST = 100
"""Minimum number of samples of such a run."""
Options = Mapping[str, Any]


class Hint(NamedTuple):
    """Options, and what the log looks like if they are right."""

    words: str
    options: Options

    @property
    def text(self) -> str:
        """The options on the command line, and in Python."""
        words, python = ["exidyn import"], []
        for name, value in self.options.items():
            if name == "units":
                each = (f"{s}={u if isinstance(u, str) else ','.join(u)}" for s, u in value.items())
                words.append(f"--units {' '.join(each)}")
                python.append(f"units={value}")
            else:
                words.append(f"--{name}" if value is True else f"--{name} HZ")
                python.append(f"{name}={value if value is True else 'HZ'}")
        return f"{' '.join(words)} (in Python {', '.join(python)})"


def import_with_hints(
    function: Callable[..., list[Recording]], source: Any, model: Model | None, options: Options
) -> list[Recording]:
    """Result of an importer; an error about units or times names the options that cure it."""
    try:
        return function(source, model, **options)
    except (BadUnit, BadTime) as error:
        if not error.fact or model is None:
            raise
        works = [
            hint for hint in _hints(model.robot, options) if _works(function, source, model, options, hint)
        ]
        if not works:
            raise
        if "rate" in works[0].options:
            raise type(error)(f"{error}: {works[0].text}") from error
        # Angles may be in degrees or percent; of lengths, the first that is within the limits counts.
        shown = works[: 2 if model.robot.revolute.all() else 1]
        text = "; or ".join(f"like {hint.words}: {hint.text}" for hint in shown)
        raise type(error)(f"{error.fact}. It looks {text}") from error


def _hints(robot: Robot, options: Options) -> Iterator[Hint]:
    """Hints for a robot, the simple ones first; stated units are left as they are."""
    stated, degrees = {*options.get("units", {})}, bool(options.get("degrees"))
    positions = [] if "position" in stated else list(_positions(robot, degrees))
    times = [Hint(words, {"units": {"time": unit}}) for words, unit in TIMES if "time" not in stated]
    yield from positions
    yield from times
    yield from (Hint(unit, {"units": {s: unit}}) for s, unit in EFFORTS if s not in stated)
    yield Hint("a log without time", {"rate": 100.0})
    for position, time in product(positions, times):
        yield Hint(f"{position.words} and {time.words}", _merged(position.options, time.options))


def _merged(options: Options, more: Options) -> Options:
    """Both options, with the units of both."""
    units = {**options.get("units", {}), **more.get("units", {})}
    return {**options, **more, **({"units": units} if units else {})}


TIMES = (("milliseconds", "ms"), ("microseconds", "us"), ("nanoseconds", "ns"))
EFFORTS = (("current", "mA"), ("torque", "mN m"))


def _positions(robot: Robot, degrees: bool) -> Iterator[Hint]:
    """Units of positions of an arm, as controllers have them; `degrees` are stated for revolute joints."""
    revolute = robot.revolute
    if not revolute.all():
        if revolute.any() and not degrees:
            yield Hint("degrees and meters", {"degrees": True})
        # An arm in degrees moves farther than any in radians, which is then refused.
        for turning in (*["rad"] * (not degrees), "deg") if revolute.any() else ("",):
            unit = [turning if turns else "mm" for turns in revolute.tolist()]
            words = "degrees and millimeters" if turning == "deg" else "millimeters"
            yield Hint(words, {"units": {"position": unit if turning else "mm"}})
    elif not degrees:
        yield Hint("degrees", {"degrees": True})
    if not degrees and np.isfinite(robot.limits.position_upper - robot.limits.position_lower).all():
        yield Hint("percent of each joint's travel", {"units": {"position": "%"}})


def _works(
    function: Callable[..., list[Recording]], source: Any, model: Model, options: Options, hint: Hint
) -> bool:
    """Whether a log can be imported with a hint."""
    try:
        runs = function(source, model, **_merged(options, hint.options))
    except (RecordingError, TypeError):  # TypeError: this importer has no such option
        return False
    longest = max(runs, key=lambda run: run.duration, default=None)
    if longest is None:
        return False
    position = longest.signals["position"].values
    if np.any(beyond_limits(model.robot.limits, position)[~model.robot.revolute] > BEYOND_LIMITS):
        return False
    if "time" in hint.options.get("units", {}) and (longest.duration < SHORTEST or len(position) < FEWEST):
        return False
    if hint.options.get("units", {}).get("position") != "%":
        return True
    return bool(np.max(beyond_limits(model.robot.limits, position)) < BEYOND_LIMITS)
