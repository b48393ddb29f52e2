"""Units, order of joints and mounting that `exidyn init` proposes for a log without stated units."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..model import Model
from ..recordings.recording import EFFORT
from ..recordings.tables.column_names import Family
from ..text_table import digits, percent
from .change import Change, scaled, with_gravity
from .evidence import Reading
from .gains import TORQUE, effort_odds, gains
from .imported_log import Log, Signs
from .joint_mistakes import order_of
from .mistake import LogFacts
from .samples import sampled
from .search import FAR_BEHIND, MOST, Explanation, Weighed, posterior, weigh
from .size_mistakes import direction_words
from .suspicion import DECIDED, Guess
from .units import FREE, TIME, Units, affine, moves, other_unit_odds, unit_odds, units_of, with_fixed

AS_NUMBERED = 0.99
"""Probability that numbered columns are in the robot's order."""
ORDERS = frozenset({"exchanged_columns", "order", "exchanged_chains"})
"""Mistakes in the order of joints."""
SHAPES = frozenset(
    {
        "exchanged_positions",
        "exchanged_efforts",
        "position_sign",
        "joint_direction",
        "position_scale",
        "sum_of_positions",
        "no_gravity",
        "upside_down",
    }
)
"""Mistakes that can be detected with any unit of the efforts."""
DIRECTIONS = frozenset({"position_sign", "joint_direction"})
"""Mistakes that signs in a preset correct."""
GRAVITY = "direction of gravity"
"""Question that a guess of the mounting answers."""


def reading_of(log: Log, model: Model, units: Units) -> Reading:
    """Reading of a log with units of time and position."""
    position = log.values["position"]
    effort = next(log.values[signal] for signal in EFFORT if signal in log.values)
    samples = sampled(log.time * TIME[units.time], position, effort).thinned(MOST)
    scale, zero = affine(model.robot, units.position, position)
    return Reading(model, samples, False).changed(Change(position=scaled(scale), zero=zero))


class Proposed(NamedTuple):
    """Units, order and mounting of a log."""

    units: Units  # units of time, position and velocity; "" for a velocity that is left out
    order: tuple[int, ...]  # column of each joint, in the robot's order
    reading: Reading  # reading in SI units and in the robot's order, with the most probable gravity
    # Gravity in the base frame, shape (3,) [m/s^2], if it certainly differs from the description; else empty.
    gravity: tuple[float, ...]
    guesses: list[Guess]  # guesses with their probabilities
    doubt: str  # sentence on another probable mistake, or ""
    doubted: tuple[int, ...]  # indices of the joints that the doubt concerns
    signs: Signs | None  # signs of positions and efforts if joints count the other way


def joint_odds(log: Log, model: Model, stated: Units, fixed: Units = FREE) -> dict[Units, float]:
    """Log odds of combinations of units with the `fixed` ones, from speeds, limits, velocities and bodies."""
    robot = model.robot
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    driven = np.any([log.values[name].any(axis=0) for name in EFFORT if name in log.values], axis=0)
    if driven.any():  # a joint without a drive may exceed its speed limit
        seen = seen._replace(speed=seen.speed * driven)
    odds = with_fixed(unit_odds(seen, robot, log.values["position"], stated), fixed)
    # All use the same unit of time, since with another unit the filters would select other samples.
    best = next(iter(posterior(odds)))
    by_bodies: dict[str, float] = {}
    for units, value in odds.items():
        if units.position not in by_bodies and value > odds[best] - 2 * FAR_BEHIND:
            reading = reading_of(log, model, units._replace(time=best.time))
            by_bodies[units.position] = reading.evidence.log_likelihood
    least = min(by_bodies.values())
    return {units: value + by_bodies.get(units.position, least) for units, value in odds.items()}


def stated_units(chosen: Mapping[str, Family], clock: str) -> Units:
    """Units that the names of columns state, "" for none; `clock` is that of the time."""
    return Units(clock, chosen["position"].unit, chosen["velocity"].unit if "velocity" in chosen else "")


def propose_units(
    log: Log, model: Model, chosen: Mapping[str, Family], stated: Units, fixed: Units
) -> Proposed:
    """Most probable units, order and mounting, each with its probability.

    The names of columns state the units `stated`; `fixed` units are certain. Both are "" where unknown.
    """
    family = chosen["position"]
    likely = posterior(joint_odds(log, model, stated, fixed))
    best = next(iter(likely))
    reading = reading_of(log, model, best)
    effort = next(signal for signal in EFFORT if signal in chosen)
    sure = posterior(effort_odds(gains(reading), chosen[effort].signal))[TORQUE] > DECIDED
    weighed = _weighed(replace(reading, stated=sure), model, family.by_name)
    why = _reasons(log, model.robot, best)
    guesses = [_unit_guess(model.robot, part, best, why[part], likely) for part in why]
    place = list(why).index("position")
    guesses[place] = _among_others(log, model.robot, best, guesses[place], weighed)
    order = tuple(range(model.robot.dof))
    if not family.by_name and len(order) > 1:
        guess, order = _order(weighed, len(order))
        guesses.append(guess)
    gravity: tuple[float, ...] = ()
    if (mounted := _mounting(weighed, reading)) is not None:
        guess, direction = mounted
        guesses.append(guess)
        if guess.decided:
            gravity = tuple(direction.tolist())
            reading = replace(reading, model=with_gravity(model, direction))
    signs, turned = _directions(weighed, reading)
    if order == tuple(range(len(order))):
        reading = turned
    else:
        matrix = np.eye(len(order))[list(order)]
        reading = reading.changed(Change(position=matrix, effort=matrix))
    units = best if "velocity" in why else best._replace(velocity="")
    doubt, doubted = _doubt(weighed)
    return Proposed(units, order, reading, gravity, guesses, doubt, () if signs else doubted, signs)


def _weighed(reading: Reading, model: Model, by_name: bool) -> Weighed:
    kinds = SHAPES if by_name else SHAPES | ORDERS
    facts = LogFacts(model.robot, reading.log, np.full(model.robot.dof, np.nan), False)
    return weigh(reading, facts, kinds)


def _likeliest(weighed: Weighed, kinds: frozenset[str]) -> tuple[Explanation | None, float]:
    """Most probable single mistake of some kinds, and the total probability of these kinds."""
    single = [each for each in weighed.explanations if len(each.mistakes) == 1]
    alike = [each for each in single if each.mistakes[0].name in kinds]
    return (alike[0], sum(map(weighed.share, alike))) if alike else (None, 0.0)


def _order(weighed: Weighed, n: int) -> tuple[Guess, tuple[int, ...]]:
    likeliest, share = _likeliest(weighed, ORDERS)
    why, option = f"bodies; {len(weighed.explanations)} alternatives", "[position] column in a preset"
    order = None if likeliest is None else order_of(likeliest.change)
    if likeliest is None or order is None or weighed.share(likeliest) < 0.5 or not likeliest.reading.fits:
        sure = min(AS_NUMBERED, 1.0 - share)
        return Guess("order of joints", "as numbered", sure, why, option), tuple(range(n))
    value = ", ".join(str(k + 1) for k in order)
    return Guess("order of joints", value, weighed.share(likeliest), why, option), tuple(order.tolist())


def _mounting(weighed: Weighed, reading: Reading) -> tuple[Guess, np.ndarray] | None:
    """Guess of gravity if a direction other than the described one is more probable."""
    likeliest, share = _likeliest(weighed, frozenset({"mounting", "upside_down", "no_gravity"}))
    if likeliest is None or likeliest.change.gravity is None or share < 0.5:
        return None
    gravity = likeliest.change.gravity
    size = float(np.linalg.norm(gravity))
    value = f"{direction_words(gravity / size)} of the base" if size else "none: the efforts lack the weight"
    probability = (
        weighed.share(likeliest) if likeliest.reading.fits else min(weighed.share(likeliest), DECIDED)
    )
    return Guess(GRAVITY, value, probability, "bodies, friction", "gravity in robot.toml"), gravity


def _doubt(weighed: Weighed) -> tuple[str, tuple[int, ...]]:
    """Sentence on a probable mistake other than unit, order and mounting, and the joints concerned."""
    likeliest, _ = _likeliest(weighed, SHAPES - {"no_gravity", "upside_down"})
    if likeliest is None or weighed.named is not likeliest or weighed.probability < 0.5:
        return "", ()
    cure = likeliest.cases[0].cure or likeliest.mistakes[0].cure
    return (
        f"{likeliest.cases[0].clause} (probability {percent(weighed.probability)}): {cure}",
        likeliest.joints,
    )


def _directions(weighed: Weighed, reading: Reading) -> tuple[Signs | None, Reading]:
    """Signs of positions and efforts, and the log with them, if joints certainly count the other way."""
    likeliest = weighed.named
    if not _only_turned(weighed) or likeliest is None or likeliest.change.position is None:
        return None, reading
    turned = reading.changed(Change(position=likeliest.change.position))
    position = np.diag(likeliest.change.position)
    against = np.array([gain.positive < 1.0 - DECIDED for gain in gains(turned)])
    effort = np.where((position < 0.0) & against, -1.0, 1.0)
    return Signs(position.tolist(), effort.tolist()), turned.changed(Change(effort=scaled(effort)))


def _only_turned(weighed: Weighed) -> bool:
    """Whether joints that count the other way certainly are the only mistake."""
    likeliest = weighed.named
    kinds = set() if likeliest is None else {mistake.name for mistake in likeliest.mistakes}
    return bool(kinds) and kinds <= DIRECTIONS and weighed.probability > DECIDED


def _among_others(log: Log, robot: Robot, units: Units, guess: Guess, weighed: Weighed) -> Guess:
    """Guess of the position unit, adjusted for the probability of an unlisted unit or a scale factor.

    With an unlisted unit, bodies do not explain the efforts.
    """
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    other = other_unit_odds(seen, robot, log.values["position"], units)
    fits = weighed.plain.reading.fits or _only_turned(weighed)
    among = 1.0 if fits else float(1 / (1 + np.exp(other)))
    if among < 0.5:
        return replace(guess, value="", probability=0.0, option="positions in radians or meters")
    likeliest, scaled = _likeliest(weighed, frozenset({"position_scale"}))
    scaled = scaled if likeliest is not None and likeliest.right else 0.0
    return replace(guess, probability=guess.probability * among * (1.0 - scaled))


def _reasons(log: Log, robot: Robot, units: Units) -> dict[str, str]:
    """Evidence for the unit of time, position and, if there is a column, velocity."""
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    rate = 1.0 / (seen.period * TIME[units.time])
    scale, _ = affine(robot, units.position, log.values["position"])
    fast = float(np.nanmax(seen.speed * scale / TIME[units.time]))
    speed = f"{digits(fast)} {'rad' if robot.revolute.any() else 'm'}/s at most"
    reasons = {"time": f"{digits(rate)} Hz, {speed}", "position": "limits, speeds, bodies"}
    return reasons | ({"velocity": "derivative of position"} if np.isfinite(seen.ratio) else {})


def _unit_guess(robot: Robot, part: str, best: Units, why: str, likely: Mapping[Units, float]) -> Guess:
    """Guess of the unit of time, position or velocity; for both kinds of joints if the robot has both."""
    unit = getattr(best, part)
    mixed = part != "time" and robot.revolute.any() and not robot.revolute.all()
    probability = sum(p for units, p in likely.items() if getattr(units, part) == unit)
    per = "/s" if part == "velocity" and unit != "rpm" else ""
    value = ", ".join(dict.fromkeys(units_of(robot, unit, per))) if mixed else unit + per
    return Guess(f"unit of {part}", value, probability, why, f"[{part}] unit in a preset")
