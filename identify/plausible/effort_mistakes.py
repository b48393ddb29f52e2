"""Mistakes of efforts and of the weight in them: signs, units, drives and gravity."""

from collections.abc import Callable, Iterator
from itertools import combinations
from types import MappingProxyType

import numpy as np

from ..text_table import digits
from .asked import Asked, Case
from .changes import Change
from .described_bodies import KINDS

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


def turned_efforts(count: int) -> Callable[[Asked], Iterator[Case]]:
    """Efforts of one or two joints that count the other way."""

    def cases(asked: Asked) -> Iterator[Case]:
        for which in combinations(asked.moving, count) if count < len(asked.moving) else ():
            names = " and ".join(asked.joints[j] for j in which)
            words = (
                "the effort of {} counts against its motion"
                if count == 1
                else "the efforts of {} count against their motion"
            )
            yield words.format(names), Change(factor=asked.where(dict.fromkeys(which, -1.0))), which

    return cases


def all_turned(asked: Asked) -> Iterator[Case]:
    """Efforts that all count the other way."""
    yield (
        "all efforts count against their motion",
        Change(factor=-np.ones(asked.robot.dof)),
        tuple(asked.moving),
    )


def effort_units(asked: Asked) -> Iterator[Case]:
    """Efforts of all joints in another unit."""
    for factor, unit in UNITS.items():
        change = Change(factor=np.full(asked.robot.dof, factor))
        yield f"the efforts are in {unit}{_off(asked)}", change, tuple(asked.moving)


def one_effort_unit(asked: Asked) -> Iterator[Case]:
    """The effort of one joint in another unit."""
    for j in asked.moving if len(asked.moving) > 1 else ():
        for factor, unit in UNITS.items():
            words = f"the effort of {asked.joints[j]} is in {unit}{_off(asked, (j,))}"
            yield words, Change(factor=asked.where({j: factor})), (j,)


def unknown_unit(asked: Asked) -> Iterator[Case]:
    """Efforts of all joints in a unit that is not listed."""
    known = asked.ratio[np.isfinite(asked.ratio)]
    common = float(np.median(known)) if len(known) > 1 else 1.0
    listed = np.log([1.0, *UNITS])
    if np.abs(np.log(common) - listed).min() > KINDS[0].spread and abs(np.log(common)) > FAR:
        words = (
            f"the efforts are in a unit that is not stated, all off by about {digits(common, 2)}{_off(asked)}"
        )
        yield words, Change(factor=np.full(asked.robot.dof, common)), tuple(asked.moving)


def effort_groups(asked: Asked) -> Iterator[Case]:
    """Efforts of the first or the last joints that are off alike."""
    n, known = asked.robot.dof, np.isfinite(asked.ratio)
    for k in range(2, n - 1):
        for group, others in ((range(k), range(k, n)), (range(k, n), range(k))):
            if not known[list(others)].any():  # all that is known is off alike: that is the unit of all
                continue
            yield from _off_alike(
                asked, tuple(group), "the efforts of {} are off by a common factor of about {}"
            )


def wrong_gears(asked: Asked) -> Iterator[Case]:
    """The effort of one joint that is off by any factor."""
    for j in asked.moving:
        words = "the effort of {} is off by a factor of about {}: its gear ratio or torque constant is wrong"
        yield from _off_alike(asked, (j,), words)


def _off_alike(asked: Asked, group: tuple[int, ...], words: str) -> Iterator[Case]:
    logs = np.log(asked.ratio[list(group)])
    logs = logs[np.isfinite(logs)]
    if len(logs) >= min(2, len(group)) and abs(np.median(logs)) > FAR:
        factor = float(np.exp(np.median(logs)))
        names = asked.joints[group[0]] + (f" to {asked.joints[group[-1]]}" if len(group) > 1 else "")
        change = Change(factor=asked.where(dict.fromkeys(group, factor)))
        yield words.format(names, digits(factor, 2)), change, group


def torque_constants(asked: Asked) -> Iterator[Case]:
    """Torque constants that were not applied, or twice."""
    if np.all(asked.constants == 1.0):
        return
    size = np.abs(asked.constants)
    if asked.torques:
        yield (
            "the torques are currents: no torque constant was applied",
            Change(factor=size),
            tuple(asked.moving),
        )
    words = "the currents are torques already" if not asked.torques else "the torques were multiplied"
    twice = f"{words}: the torque constant was applied twice"
    yield twice, Change(factor=1.0 / size), tuple(asked.moving)


def motor_side(asked: Asked) -> Iterator[Case]:
    """Torques of the motors, before the gears."""
    if not asked.torques or asked.servo:
        return
    stated = np.abs(asked.robot.gear_ratio)
    for ratio in [stated] if np.any(stated != 1.0) else [np.full(asked.robot.dof, ratio) for ratio in GEARS]:
        words = f"the torques are the motors', before gears of about {digits(float(np.median(ratio)), 2)}"
        yield words, Change(factor=ratio), tuple(asked.moving)


def servo_gains(asked: Asked) -> Iterator[Case]:
    """Gains of position servos that are not those of the log."""
    known = np.isfinite(asked.ratio)
    if asked.servo and known.any() and abs(np.median(np.log(asked.ratio[known]))) > FAR:
        gains = asked.constants * asked.ratio
        said = ", ".join(f"{digits(gains[j], 3)} ({asked.joints[j]})" for j in np.flatnonzero(known))
        stated = digits(float(np.median(asked.constants)), 4)
        factor = np.where(known, asked.ratio, np.median(asked.ratio[known]))
        yield (
            f"the servo gain stated is {stated} N m/rad, the bodies say {said}",
            Change(factor=factor),
            tuple(np.flatnonzero(known).tolist()),
        )


def another_arm(asked: Asked) -> Iterator[Case]:
    """Another arm, or other drives: any gains and any masses."""
    change = Change(factor=np.full(asked.robot.dof, np.nan))
    words = f"another arm than {asked.robot.name} was recorded, or one with other drives"
    yield words, change, tuple(asked.moving)


def no_gravity(asked: Asked) -> Iterator[Case]:
    """Efforts without the weight of the arm."""
    if np.any(asked.robot.gravity):
        words = "the efforts lack the weight of the arm: gravity is compensated"
        yield words, Change(gravity=np.zeros(3)), tuple(asked.moving)


def upside_down(asked: Asked) -> Iterator[Case]:
    """An arm that hangs and is described standing, or the reverse."""
    size = float(np.linalg.norm(asked.robot.gravity))
    if size > 0 and len(asked.moving) > 1:
        direction = direction_words(-asked.robot.gravity / size)
        words = f"gravity points along {direction} of the base, opposite to the description"
        yield words, Change(gravity=-asked.robot.gravity), tuple(asked.moving)


def of_gravity(asked: Asked, gravity: np.ndarray) -> Iterator[Case]:
    """An arm that stands otherwise than its description has it."""
    direction = gravity / np.linalg.norm(gravity)
    words = f"gravity points along {direction_words(direction)} of the base"
    yield words, Change(gravity=gravity), tuple(asked.moving)


def direction_words(direction: np.ndarray) -> str:
    """A direction as three numbers."""
    return ", ".join(f"{part + 0.0:.2f}" for part in np.round(direction, 2))


def _off(asked: Asked, joints: tuple[int, ...] = ()) -> str:
    ratio = asked.ratio[list(joints)] if joints else asked.ratio
    known = ", ".join(digits(value, 2) for value in ratio[np.isfinite(ratio)])
    return f" (by masses and friction {known} times the torque stated)" if known else ""
