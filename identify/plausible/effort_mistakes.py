"""Mistakes in efforts and gravity: signs, units, drive constants and mounting."""

from collections.abc import Callable, Iterator
from itertools import combinations
from types import MappingProxyType

import numpy as np

from ..text_table import digits
from .described_bodies import KINDS
from .mistake import Case, Change, LogFacts

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


def turned_efforts(count: int) -> Callable[[LogFacts], Iterator[Case]]:
    """Wrong sign of the efforts of one or two joints."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        for joints in combinations(facts.moving, count) if count < len(facts.moving) else ():
            names = " and ".join(facts.joints[j] for j in joints)
            words = f"the effort of {names} has" if count == 1 else f"the efforts of {names} have"
            change = Change(factor=facts.where(dict.fromkeys(joints, -1.0)))
            yield f"{words} the opposite sign", change, joints

    return cases


def all_turned(facts: LogFacts) -> Iterator[Case]:
    """Wrong sign of all efforts."""
    yield facts.of_all("all efforts have the opposite sign", Change(factor=-np.ones(facts.robot.dof)))


def effort_units(facts: LogFacts) -> Iterator[Case]:
    """Efforts of all joints in another unit."""
    for factor, unit in UNITS.items():
        change = Change(factor=np.full(facts.robot.dof, factor))
        yield facts.of_all(f"the efforts are in {unit}{_off(facts)}", change)


def one_effort_unit(facts: LogFacts) -> Iterator[Case]:
    """The effort of one joint in another unit."""
    for j in facts.moving if len(facts.moving) > 1 else ():
        for factor, unit in UNITS.items():
            words = f"the effort of {facts.joints[j]} is in {unit}{_off(facts, (j,))}"
            yield words, Change(factor=facts.where({j: factor})), (j,)


def unknown_unit(facts: LogFacts) -> Iterator[Case]:
    """Efforts of all joints in a unit that is not in the list."""
    known = facts.ratio[np.isfinite(facts.ratio)]
    common = float(np.median(known)) if len(known) > 1 else 1.0
    listed = np.log([1.0, *UNITS])
    if np.abs(np.log(common) - listed).min() > KINDS[0].spread and abs(np.log(common)) > FAR:
        words = (
            f"the efforts are in an unstated unit, off by a factor of about {digits(common, 2)}{_off(facts)}"
        )
        yield facts.of_all(words, Change(factor=np.full(facts.robot.dof, common)))


def effort_groups(facts: LogFacts) -> Iterator[Case]:
    """A common factor on the efforts of the first or the last joints."""
    n, known = facts.robot.dof, np.isfinite(facts.ratio)
    for k in range(2, n - 1):
        for group, others in ((range(k), range(k, n)), (range(k, n), range(k))):
            if not known[list(others)].any():  # if all known efforts are wrong alike, it is the common unit
                continue
            yield from _off_alike(
                facts, tuple(group), "the efforts of {} are wrong by a common factor of about {}"
            )


def wrong_gears(facts: LogFacts) -> Iterator[Case]:
    """An arbitrary factor on the effort of one joint."""
    for j in facts.moving:
        words = "the effort of {} is wrong by a factor of about {}, from its gear ratio or torque constant"
        yield from _off_alike(facts, (j,), words)


def _off_alike(facts: LogFacts, group: tuple[int, ...], words: str) -> Iterator[Case]:
    logs = np.log(facts.ratio[list(group)])
    logs = logs[np.isfinite(logs)]
    if len(logs) and abs(np.median(logs)) > FAR:
        factor = float(np.exp(np.median(logs)))
        names = facts.joints[group[0]] + (f" to {facts.joints[group[-1]]}" if len(group) > 1 else "")
        change = Change(factor=facts.where(dict.fromkeys(group, factor)))
        yield words.format(names, digits(factor, 2)), change, group


def torque_constants(facts: LogFacts) -> Iterator[Case]:
    """Torque constants that were not applied, or applied twice."""
    if np.all(facts.constants == 1.0):
        return
    size = np.abs(facts.constants)
    if facts.torques:
        words = "the torques are currents, since no torque constant was applied"
        yield facts.of_all(words, Change(factor=size))
    words = "the currents already are torques" if not facts.torques else "the torques were multiplied"
    twice = f"{words}, so the torque constant was applied twice"
    yield facts.of_all(twice, Change(factor=1.0 / size))


def motor_side(facts: LogFacts) -> Iterator[Case]:
    """Motor-side torques."""
    if not facts.torques or facts.servo:
        return
    stated = np.abs(facts.robot.gear_ratio)
    for ratio in [stated] if np.any(stated != 1.0) else [np.full(facts.robot.dof, ratio) for ratio in GEARS]:
        words = f"the torques are motor torques before gears of ratio {digits(float(np.median(ratio)), 2)}"
        yield facts.of_all(words, Change(factor=ratio))


def servo_gains(facts: LogFacts) -> Iterator[Case]:
    """Stated gains of position servos that differ from those of the log."""
    known = np.isfinite(facts.ratio)
    if facts.servo and known.any() and abs(np.median(np.log(facts.ratio[known]))) > FAR:
        gains = facts.constants * facts.ratio
        said = ", ".join(f"{digits(gains[j], 3)} ({facts.joints[j]})" for j in np.flatnonzero(known))
        stated = digits(float(np.median(facts.constants)), 4)
        factor = np.where(known, facts.ratio, np.median(facts.ratio[known]))
        words = f"the stated servo gain is {stated} N m/rad, but the bodies require {said}"
        yield words, Change(factor=factor), tuple(np.flatnonzero(known).tolist())


def another_arm(facts: LogFacts) -> Iterator[Case]:
    """Arbitrary gains and masses: each joint fits alone, as with another arm or a joint of opposite sign."""
    change = Change(factor=np.full(facts.robot.dof, np.nan))
    words = (
        f"each joint fits alone, but not together with the others as {facts.robot.name} is described: "
        "another arm or other drives were recorded, or joints are exchanged or count the other way"
    )
    yield facts.of_all(words, change)


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


def of_gravity(facts: LogFacts, gravity: np.ndarray) -> Iterator[Case]:
    """A mounting that differs from the description."""
    direction = gravity / np.linalg.norm(gravity)
    words = f"gravity points along {direction_words(direction)} of the base"
    yield facts.of_all(words, Change(gravity=gravity))


def direction_words(direction: np.ndarray) -> str:
    """A direction as text with three numbers."""
    return ", ".join(f"{part + 0.0:.2f}" for part in np.round(direction, 2))


def _off(facts: LogFacts, joints: tuple[int, ...] = ()) -> str:
    ratio = facts.ratio[list(joints)] if joints else facts.ratio
    known = ", ".join(digits(value, 2) for value in ratio[np.isfinite(ratio)])
    return f" (masses and friction require {known} times the stated torque)" if known else ""
