"""Mistakes of efforts and of the weight in them: signs, units, drives and gravity."""

from collections.abc import Callable, Iterator
from itertools import combinations
from types import MappingProxyType

import numpy as np

from ..text_table import digits
from .changes import Change
from .described_bodies import KINDS
from .log_facts import Case, LogFacts

UNITS = MappingProxyType(
    {
        1e-3: "thousandths (mA, mN m)",
        1e-2: "hundredths, or per cent",
        0.0980665: "kgf cm",
        9.80665: "kgf m",
        1e3: "thousands",
        0.11298: "lbf in",
    }
)
"""Torque of a number over that in the unit stated, and that unit's name. A foot-pound is not among them:
1.36 N m are as well a gain that is off."""
GEARS = (30.0, 50.0, 80.0, 120.0, 160.0, 250.0)
"""Ratios of gears that arms have."""
FAR = 2.0 * KINDS[0].spread
"""Logarithm of a gain over the one stated from which on masses do not explain it: two standard deviations."""


def turned_efforts(count: int) -> Callable[[LogFacts], Iterator[Case]]:
    """Efforts of one or two joints that count the other way."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        for which in combinations(facts.moving, count) if count < len(facts.moving) else ():
            names = " and ".join(facts.joints[j] for j in which)
            words = (
                "the effort of {} counts against its motion"
                if count == 1
                else "the efforts of {} count against their motion"
            )
            yield words.format(names), Change(factor=facts.where(dict.fromkeys(which, -1.0))), which

    return cases


def all_turned(facts: LogFacts) -> Iterator[Case]:
    """Efforts that all count the other way."""
    yield (
        "all efforts count against their motion",
        Change(factor=-np.ones(facts.robot.dof)),
        tuple(facts.moving),
    )


def effort_units(facts: LogFacts) -> Iterator[Case]:
    """Efforts of all joints in another unit."""
    for factor, unit in UNITS.items():
        change = Change(factor=np.full(facts.robot.dof, factor))
        yield f"the efforts are in {unit}{_off(facts)}", change, tuple(facts.moving)


def one_effort_unit(facts: LogFacts) -> Iterator[Case]:
    """The effort of one joint in another unit."""
    for j in facts.moving if len(facts.moving) > 1 else ():
        for factor, unit in UNITS.items():
            words = f"the effort of {facts.joints[j]} is in {unit}{_off(facts, (j,))}"
            yield words, Change(factor=facts.where({j: factor})), (j,)


def unknown_unit(facts: LogFacts) -> Iterator[Case]:
    """Efforts of all joints in a unit that is not listed."""
    known = facts.ratio[np.isfinite(facts.ratio)]
    common = float(np.median(known)) if len(known) > 1 else 1.0
    listed = np.log([1.0, *UNITS])
    if np.abs(np.log(common) - listed).min() > KINDS[0].spread and abs(np.log(common)) > FAR:
        words = (
            f"the efforts are in a unit that is not stated, all off by about {digits(common, 2)}{_off(facts)}"
        )
        yield words, Change(factor=np.full(facts.robot.dof, common)), tuple(facts.moving)


def effort_groups(facts: LogFacts) -> Iterator[Case]:
    """Efforts of the first or the last joints that are off alike."""
    n, known = facts.robot.dof, np.isfinite(facts.ratio)
    for k in range(2, n - 1):
        for group, others in ((range(k), range(k, n)), (range(k, n), range(k))):
            if not known[list(others)].any():  # all that is known is off alike: that is the unit of all
                continue
            yield from _off_alike(
                facts, tuple(group), "the efforts of {} are off by a common factor of about {}"
            )


def wrong_gears(facts: LogFacts) -> Iterator[Case]:
    """The effort of one joint that is off by any factor."""
    for j in facts.moving:
        words = "the effort of {} is off by a factor of about {}: its gear ratio or torque constant is wrong"
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
    """Torque constants that were not applied, or twice."""
    if np.all(facts.constants == 1.0):
        return
    size = np.abs(facts.constants)
    if facts.torques:
        yield (
            "the torques are currents: no torque constant was applied",
            Change(factor=size),
            tuple(facts.moving),
        )
    words = "the currents are torques already" if not facts.torques else "the torques were multiplied"
    twice = f"{words}: the torque constant was applied twice"
    yield twice, Change(factor=1.0 / size), tuple(facts.moving)


def motor_side(facts: LogFacts) -> Iterator[Case]:
    """Torques of the motors, before the gears."""
    if not facts.torques or facts.servo:
        return
    stated = np.abs(facts.robot.gear_ratio)
    for ratio in [stated] if np.any(stated != 1.0) else [np.full(facts.robot.dof, ratio) for ratio in GEARS]:
        words = f"the torques are the motors', before gears of about {digits(float(np.median(ratio)), 2)}"
        yield words, Change(factor=ratio), tuple(facts.moving)


def servo_gains(facts: LogFacts) -> Iterator[Case]:
    """Gains of position servos that are not those of the log."""
    known = np.isfinite(facts.ratio)
    if facts.servo and known.any() and abs(np.median(np.log(facts.ratio[known]))) > FAR:
        gains = facts.constants * facts.ratio
        said = ", ".join(f"{digits(gains[j], 3)} ({facts.joints[j]})" for j in np.flatnonzero(known))
        stated = digits(float(np.median(facts.constants)), 4)
        factor = np.where(known, facts.ratio, np.median(facts.ratio[known]))
        yield (
            f"the servo gain stated is {stated} N m/rad, the bodies say {said}",
            Change(factor=factor),
            tuple(np.flatnonzero(known).tolist()),
        )


def another_arm(facts: LogFacts) -> Iterator[Case]:
    """Another arm, or other drives: any gains and any masses."""
    change = Change(factor=np.full(facts.robot.dof, np.nan))
    words = f"another arm than {facts.robot.name} was recorded, or one with other drives"
    yield words, change, tuple(facts.moving)


def no_gravity(facts: LogFacts) -> Iterator[Case]:
    """Efforts without the weight of the arm."""
    if np.any(facts.robot.gravity):
        words = "the efforts lack the weight of the arm: gravity is compensated"
        yield words, Change(gravity=np.zeros(3)), tuple(facts.moving)


def upside_down(facts: LogFacts) -> Iterator[Case]:
    """An arm that hangs and is described standing, or the reverse."""
    size = float(np.linalg.norm(facts.robot.gravity))
    if size > 0 and len(facts.moving) > 1:
        direction = direction_words(-facts.robot.gravity / size)
        words = f"gravity points along {direction} of the base, opposite to the description"
        yield words, Change(gravity=-facts.robot.gravity), tuple(facts.moving)


def of_gravity(facts: LogFacts, gravity: np.ndarray) -> Iterator[Case]:
    """An arm that stands otherwise than its description has it."""
    direction = gravity / np.linalg.norm(gravity)
    words = f"gravity points along {direction_words(direction)} of the base"
    yield words, Change(gravity=gravity), tuple(facts.moving)


def direction_words(direction: np.ndarray) -> str:
    """A direction as three numbers."""
    return ", ".join(f"{part + 0.0:.2f}" for part in np.round(direction, 2))


def _off(facts: LogFacts, joints: tuple[int, ...] = ()) -> str:
    ratio = facts.ratio[list(joints)] if joints else facts.ratio
    known = ", ".join(digits(value, 2) for value in ratio[np.isfinite(ratio)])
    return f" (by masses and friction {known} times the torque stated)" if known else ""
