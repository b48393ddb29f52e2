"""Mistakes in sizes: units and scales of positions and efforts, drive gains, and gravity."""

from collections.abc import Iterator
from types import MappingProxyType

import numpy as np

from ..text_table import digits
from .change import Change, scaled
from .described_bodies import KINDS
from .mistake import Case, LogFacts
from .units import LEAST_PERCENT, PERCENT

ANGLES = MappingProxyType(
    {
        "in degrees": np.pi / 180,
        "in radians, but read as degrees": 180 / np.pi,
        "in counts of 12 bits per turn": 2 * np.pi / 2**12,
    }
)
"""Confused unit of positions -> its size in the stated unit."""
LENGTHS = MappingProxyType({"in mm": 1e-3, "in m, but read as mm": 1e3})
"""Confused unit of sliding joints -> its size in the stated unit."""
POSITION_SCALES = (1 / 10, 1 / 4, 1 / 3, 1 / 2, 2.0, 3.0, 4.0, 10.0)
ONE_SCALE = (1 / 4, 1 / 2, 2.0, 4.0)
"""True angle over logged angle if gears or encoders were assumed wrongly, for all joints and for one."""
UNITS = MappingProxyType(
    {
        1e-3: "thousandths (mA, mN m)",
        1e-2: "hundredths, or percent",
        0.0980665: "kgf cm",
        9.80665: "kgf m",
        1e3: "thousands",
        0.11298: "lbf in",
    }
)
"""Factor of a unit relative to the stated unit -> its name. The foot-pound is missing: 1.36 N m could as well
be an inaccurate gain."""
GEARS = (30.0, 50.0, 80.0, 120.0, 160.0, 250.0)
"""Typical gear ratios of arms."""
FAR = 2.0 * KINDS[0].spread
"""Log ratio of a gain and the stated one that mass errors do not explain: two standard deviations."""


def position_units(facts: LogFacts) -> Iterator[Case]:
    """Positions of all turning or all sliding joints, or of one joint, in another unit."""
    sliding = [joint for joint in facts.moving if not facts.robot.revolute[joint]]
    for joints, units in ((facts.turning, ANGLES), (sliding, LENGTHS)):
        for words, factor in units.items() if joints else ():
            change = Change(position=facts.where(dict.fromkeys(joints, factor)))
            yield Case(f"the positions are {words}", change, tuple(joints))
    for joint in facts.turning if len(facts.turning) > 1 else ():
        change = Change(position=facts.where({joint: ANGLES["in degrees"]}))
        yield Case(f"the position of {facts.joints[joint]} is in degrees", change, (joint,))


def shares_of_travel(facts: LogFacts) -> Iterator[Case]:
    """Positions in percent of each joint's travel."""
    limits, position = facts.robot.limits, facts.log.motion.position
    if not np.isfinite([limits.position_lower, limits.position_upper]).all():
        return
    span = limits.position_upper - limits.position_lower
    middle = (limits.position_upper + limits.position_lower) / 2
    for unit, words in ((1.0, ""), (180 / np.pi, ", but read as degrees")):
        if LEAST_PERCENT < np.abs(position * unit).max() < PERCENT:
            change = Change(position=scaled(unit * span / 200.0), zero=middle)
            yield facts.of_all(f"the positions are percent of each joint's travel{words}", change)


def gear_ratios(facts: LogFacts) -> Iterator[Case]:
    """Wrong gear ratio of one joint, which affects its position and its effort."""
    for joint in facts.moving:
        for scale in ONE_SCALE:
            change = Change(facts.where({joint: scale}), effort=facts.where({joint: 1.0 / scale}))
            share = digits(1.0 / scale, 2)
            words = f"the gear ratio of {facts.joints[joint]} is about {share} times the stated one"
            yield Case(f"{words}, which affects positions and efforts", change, (joint,))


def position_scales(facts: LogFacts) -> Iterator[Case]:
    """Positions that are a fraction or a multiple of the angle."""
    turning = facts.turning
    for scale in POSITION_SCALES:
        share = f"{digits(1 / scale, 2)} of the angle"
        if len(turning) > 1:
            change = Change(position=facts.where(dict.fromkeys(turning, scale)))
            words = f"the positions look as if they were about {share} on all joints"
            yield Case(words, change, tuple(turning))
        for joint in turning if scale in ONE_SCALE else ():
            words = f"the positions of {facts.joints[joint]} look as if they were about {share}"
            yield Case(words, Change(position=facts.where({joint: scale})), (joint,))


def all_turned(facts: LogFacts) -> Iterator[Case]:
    """Wrong sign of all efforts."""
    yield facts.of_all("all efforts have the opposite sign", _times(facts, -1.0))


def effort_units(facts: LogFacts) -> Iterator[Case]:
    """Efforts of all joints, or of one, in another unit."""
    for factor, unit in UNITS.items():
        yield facts.of_all(f"the efforts are in {unit}{_off(facts)}", _times(facts, factor))
    for joint in facts.moving if len(facts.moving) > 1 else ():
        for factor, unit in UNITS.items():
            words = f"the effort of {facts.joints[joint]} is in {unit}{_off(facts, (joint,))}"
            yield Case(words, Change(effort=facts.where({joint: factor})), (joint,))


def unknown_factors(facts: LogFacts) -> Iterator[Case]:
    """A factor that is in no list: common to all efforts, to the first or last joints, or of one joint."""
    known, n = np.isfinite(facts.ratio), facts.robot.dof
    listed = np.log([1.0, *UNITS])
    common = float(np.median(facts.ratio[known])) if known.sum() > 1 else 1.0
    if np.abs(np.log(common) - listed).min() > KINDS[0].spread and abs(np.log(common)) > FAR:
        words = f"the efforts are in an unstated unit, off by a factor of about {digits(common, 2)}"
        yield facts.of_all(words + _off(facts), _times(facts, common))
    for k in range(2, n - 1):
        for group, others in ((range(k), range(k, n)), (range(k, n), range(k))):
            if known[list(others)].any():  # if all known efforts are wrong alike, it is the common unit
                words = "the efforts of {} are wrong by a common factor of about {}"
                yield from _off_alike(facts, tuple(group), words)
    for joint in facts.moving:
        words = "the effort of {} is wrong by a factor of about {}, from its gear ratio or torque constant"
        yield from _off_alike(facts, (joint,), words)


def torque_constants(facts: LogFacts) -> Iterator[Case]:
    """Torque constants that were not applied, or applied twice."""
    size = np.abs(facts.robot.drive_gain)
    if np.all(size == 1.0):
        return
    if facts.torques:
        words = "the torques are currents, since no torque constant was applied"
        yield facts.of_all(words, Change(effort=scaled(size)))
    words = "the currents already are torques" if not facts.torques else "the torques were multiplied"
    twice = f"{words}, so the torque constant was applied twice"
    yield facts.of_all(twice, Change(effort=scaled(1.0 / size)))


def motor_side(facts: LogFacts) -> Iterator[Case]:
    """Motor-side torques."""
    if not facts.torques or facts.servo:
        return
    stated = np.abs(facts.robot.gear_ratio)
    for ratio in [stated] if np.any(stated != 1.0) else [np.full(facts.robot.dof, ratio) for ratio in GEARS]:
        words = f"the torques are motor torques before gears of ratio {digits(float(np.median(ratio)), 2)}"
        yield facts.of_all(words, Change(effort=scaled(ratio)))


def servo_gains(facts: LogFacts) -> Iterator[Case]:
    """Stated gains of position servos that differ from those of the log."""
    known = np.isfinite(facts.ratio)
    if facts.servo and known.any() and abs(np.median(np.log(facts.ratio[known]))) > FAR:
        stated = facts.robot.drive_gain
        gains = stated * facts.ratio
        said = ", ".join(f"{digits(gains[j], 3)} ({facts.joints[j]})" for j in np.flatnonzero(known))
        factor = np.where(known, facts.ratio, np.median(facts.ratio[known]))
        middle = digits(float(np.median(stated)), 4)
        words = f"the stated servo gain is {middle} N m/rad, but the bodies require {said}"
        yield Case(words, Change(effort=scaled(factor)), tuple(np.flatnonzero(known).tolist()))


def no_gravity(facts: LogFacts) -> Iterator[Case]:
    """Efforts without gravity torque."""
    if np.any(facts.robot.gravity):
        words = "the efforts do not include the weight of the arm, so gravity is compensated"
        yield facts.of_all(words, Change(gravity=np.zeros(3)))


def upside_down(facts: LogFacts) -> Iterator[Case]:
    """A hanging arm that is described as standing, or the reverse."""
    size = float(np.linalg.norm(facts.robot.gravity))
    if size > 0 and len(facts.moving) > 1:
        direction = direction_words(-facts.robot.gravity / size)
        words = f"gravity points along {direction} of the base, opposite to the description"
        yield facts.of_all(words, Change(gravity=-facts.robot.gravity))


def of_gravity(facts: LogFacts, gravity: np.ndarray) -> Case:
    """A mounting that differs from the description."""
    direction = direction_words(gravity / np.linalg.norm(gravity))
    return facts.of_all(f"gravity points along {direction} of the base", Change(gravity=gravity))


def of_clocks(facts: LogFacts, late: tuple[float, float]) -> Case:
    """Efforts whose delay changes; `late` is the delay at the first sample [s] and its increase [s/s]."""
    length = float(facts.log.motion.time[-1] - facts.log.motion.time[0])
    ends = (1e3 * late[0], 1e3 * (late[0] + late[1] * length))
    words = (
        f"the efforts come later by {ends[0]:.0f} ms at the beginning and {ends[1]:.0f} ms at the end: "
        f"two clocks that differ by {digits(100 * abs(late[1]), 2)} %"
    )
    return facts.of_all(words, Change(late=late))


def direction_words(direction: np.ndarray) -> str:
    """A direction as text with three numbers."""
    return ", ".join(f"{part + 0.0:.2f}" for part in np.round(direction, 2))


def _times(facts: LogFacts, factor: float) -> Change:
    return Change(effort=factor * np.eye(facts.robot.dof))


def _off_alike(facts: LogFacts, group: tuple[int, ...], words: str) -> Iterator[Case]:
    logs = np.log(facts.ratio[list(group)])
    logs = logs[np.isfinite(logs)]
    if len(logs) and abs(np.median(logs)) > FAR:
        factor = float(np.exp(np.median(logs)))
        names = facts.joints[group[0]] + (f" to {facts.joints[group[-1]]}" if len(group) > 1 else "")
        change = Change(effort=facts.where(dict.fromkeys(group, factor)))
        yield Case(words.format(names, digits(factor, 2)), change, group)


def _off(facts: LogFacts, joints: tuple[int, ...] = ()) -> str:
    ratio = facts.ratio[list(joints)] if joints else facts.ratio
    known = ", ".join(digits(value, 2) for value in ratio[np.isfinite(ratio)])
    return f" (masses and friction require {known} times the stated torque)" if known else ""
