"""The table of mistakes: what each does to a log, how likely it is, how it is said, and what cures it.

A row is a kind of mistake. Its cases share the row's probability; each case is a clause that says what is
wrong, the change that makes the log right, and the joints concerned. Another hypothesis costs one row.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, permutations
from types import MappingProxyType

import numpy as np

from ..arm.robot import Robot
from ..text_table import digits
from .changes import Change
from .described_bodies import KINDS
from .samples import Sampled
from .units import LEAST_PERCENT, PERCENT, encoder_odds, motion_odds

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
ANGLES = MappingProxyType(
    {
        "in degrees": np.pi / 180,
        "in radians, and taken for degrees": 180 / np.pi,
        "in counts of 12 bits a turn": 2 * np.pi / 2**12,
    }
)
"""Units of positions that are taken for others, and radians a unit of what is stated."""
POSITION_SCALES = (1 / 10, 1 / 4, 1 / 3, 1 / 2, 2.0, 3.0, 4.0, 10.0)
ONE_SCALE = (1 / 4, 1 / 2, 2.0, 4.0)
"""True angle over that of the log, of gears and encoders that were assumed wrongly: of all joints, of one."""
GEARS = (30.0, 50.0, 80.0, 120.0, 160.0, 250.0)
"""Ratios of gears that arms have."""
FAR = 2.0 * KINDS[0].spread
"""Logarithm of a gain over the one stated from which on masses do not explain it: two standard deviations."""
CHAINS = 24
"""Maximum number of orders of equal chains that are weighed: those of four legs."""


@dataclass(frozen=True)
class Asked:
    """What is asked about one log.

    Attributes:
        robot: The arm as described.
        log: Its log, as it is read.
        ratio: Gain of each drive, from masses and friction, over the one stated, shape (n,); NaN where it is
            unknown or none is stated.
        constants: Drive gains of the description [N m per unit], shape (n,).
        torques: Whether the log has torques rather than currents.
        servo: Whether the efforts are errors of position servos.
        steps: Step of each joint's encoder, as the log states positions; NaN where none is seen, shape (n,).
    """

    robot: Robot
    log: Sampled
    ratio: np.ndarray
    constants: np.ndarray
    torques: bool
    servo: bool = False
    steps: np.ndarray | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.robot.joints

    @property
    def moving(self) -> list[int]:
        """Joints that move: the others show nothing."""
        return np.flatnonzero(self.log.moving).tolist()

    def where(self, joints: Mapping[int, float] | int, usual: float = 1.0) -> np.ndarray:
        """A number for some joints, and `usual` for the others, shape (n,)."""
        values = np.full(self.robot.dof, usual)
        for joint, value in joints.items() if isinstance(joints, Mapping) else ((joints, -1.0),):
            values[joint] = value
        return values

    def usual(self, change: Change) -> float:
        """Log odds of speeds, ranges and encoders without a mistake, over those that were logged."""
        if change.scale is None:
            return 0.0
        speed = np.percentile(np.abs(self.log.motion.velocity), 99.5, axis=0)
        reach = np.ptp(self.log.motion.position, axis=0)
        scales = np.abs(change.scale)
        odds = motion_odds(speed * scales, reach * scales, self.robot) - motion_odds(speed, reach, self.robot)
        if self.steps is not None:
            turning = self.robot.revolute
            plain = encoder_odds(self.steps[turning], np.ones(int(turning.sum())))
            odds += encoder_odds(self.steps[turning], scales[turning]) - plain
        return odds


Case = tuple[str, Change, tuple[int, ...]]
"""What is wrong, in a clause; what makes the log right; the joints that show it."""


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    Attributes:
        name: Identifier.
        prior: Probability that a log has it.
        cure: What to do about it.
        cases: Its cases in a log.
        physical: Whether the diagnosis finds it as a physical effect as well.
        of_sign: Whether signs show it: sizes rest on the described masses, which nobody may have measured.
        always: Whether it is asked even where bodies explain the log: bodies of any mass may hide it.
    """

    name: str
    prior: float
    cure: str
    cases: Callable[[Asked], Iterator[Case]]
    physical: bool = False
    of_sign: bool = False
    always: bool = False


def _exchanges(position: bool, effort: bool, words: str) -> Callable[[Asked], Iterator[Case]]:
    def cases(asked: Asked) -> Iterator[Case]:
        for a, b in _likely_pairs(asked):
            order = np.arange(asked.robot.dof)
            order[[a, b]] = b, a
            change = Change(position=order if position else None, effort=order if effort else None)
            yield f"{words} of {asked.joints[a]} and {asked.joints[b]} are exchanged", change, (a, b)

    return cases


def _likely_pairs(asked: Asked) -> Iterator[tuple[int, int]]:
    """Joints that may be taken for each other: of one chain, or at the same place of equal chains."""
    chains = equal_chains(asked.robot)
    place = {joint: (chain, k) for chain, joints in enumerate(chains) for k, joint in enumerate(joints)}
    for a, b in combinations(asked.moving, 2):
        if not chains or place[a][0] == place[b][0] or place[a][1] == place[b][1]:
            yield a, b


def _orders(asked: Asked) -> Iterator[Case]:
    n = asked.robot.dof
    plain = np.arange(n)
    ranks = np.array([sorted(asked.joints).index(joint) for joint in asked.joints])
    orders = {
        "are in reverse order": plain[::-1],
        "begin one late": np.roll(plain, 1),
        "begin one early": np.roll(plain, -1),
        "are sorted by name": ranks,
    }
    for words, order in orders.items():
        if n > 2 and not np.array_equal(order, plain):
            yield f"the columns {words}", Change(order, order), tuple(asked.moving)


def _chains(asked: Asked) -> Iterator[Case]:
    chains = equal_chains(asked.robot)
    usual = tuple(range(len(chains)))
    for place, order in enumerate(permutations(usual)):
        if order == usual or place >= CHAINS:
            continue
        columns = np.arange(asked.robot.dof)
        for chain, other in zip(chains, order, strict=True):
            columns[list(chain)] = chains[other]
        names = " and ".join(_first_joint(asked, chains[k]) for k in usual if order[k] != k)
        moved = tuple(j for k in usual if order[k] != k for j in chains[k])
        read = ", ".join(_first_joint(asked, chains[order.index(k)]) for k in usual)
        yield (
            f"whole chains are exchanged: those of {names}; the log has {read}",
            Change(columns, columns),
            moved,
        )


def equal_chains(robot: Robot) -> list[list[int]]:
    """Joints of each chain that starts at the base, where there are several of the same length; else none."""
    parents = [int(parent) - 1 for parent in list(robot.kinematics.parents)[1:]]
    root = list(range(len(parents)))
    for joint, parent in enumerate(parents):
        root[joint] = joint if parent < 0 else root[parent]
    chains = [[j for j, base in enumerate(root) if base == start] for start in sorted(set(root))]
    return chains if len(chains) > 1 and len({len(chain) for chain in chains}) == 1 else []


def _first_joint(asked: Asked, chain: list[int]) -> str:
    return asked.joints[chain[0]]


def _turned_positions(asked: Asked) -> Iterator[Case]:
    for j in asked.moving:
        words = f"the position of {asked.joints[j]} counts the other way"
        yield words, Change(scale=asked.where(j)), (j,)


def _angles(asked: Asked) -> Iterator[Case]:
    turning = [j for j in asked.moving if asked.robot.revolute[j]]
    for words, factor in ANGLES.items():
        if turning:
            change = Change(scale=asked.where(dict.fromkeys(turning, factor)))
            yield f"the positions are {words}", change, tuple(turning)
    for j in turning if len(turning) > 1 else ():
        change = Change(scale=asked.where({j: ANGLES["in degrees"]}))
        yield f"the position of {asked.joints[j]} is in degrees", change, (j,)


def _travel(asked: Asked) -> Iterator[Case]:
    limits, position = asked.robot.limits, asked.log.motion.position
    if not np.isfinite([limits.position_lower, limits.position_upper]).all():
        return
    span, middle = (sign(limits.position_upper, limits.position_lower) for sign in (np.subtract, np.add))
    for unit, words in ((1.0, ""), (180 / np.pi, ", and taken for degrees")):
        numbers = np.abs(position * unit)
        if LEAST_PERCENT < numbers.max() < PERCENT:
            change = Change(scale=unit * span / 200.0, zero=middle / 2)
            yield f"the positions are per cent of each joint's travel{words}", change, tuple(asked.moving)


def _scales(asked: Asked) -> Iterator[Case]:
    turning = [j for j in asked.moving if asked.robot.revolute[j]]
    for scale in POSITION_SCALES:
        share = f"{digits(1 / scale, 2)} of the angle"
        if len(turning) > 1:
            change = Change(scale=asked.where(dict.fromkeys(turning, scale)))
            yield f"the positions look as if they were about {share} on all joints", change, tuple(turning)
        for j in turning if scale in ONE_SCALE else ():
            words = f"the positions of {asked.joints[j]} look as if they were about {share}"
            yield words, Change(scale=asked.where({j: scale})), (j,)


def _turned_efforts(count: int) -> Callable[[Asked], Iterator[Case]]:
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


def _all_turned(asked: Asked) -> Iterator[Case]:
    yield (
        "all efforts count against their motion",
        Change(factor=-np.ones(asked.robot.dof)),
        tuple(asked.moving),
    )


def _effort_units(asked: Asked) -> Iterator[Case]:
    for factor, unit in UNITS.items():
        change = Change(factor=np.full(asked.robot.dof, factor))
        yield f"the efforts are in {unit}{_off(asked)}", change, tuple(asked.moving)


def _one_effort_unit(asked: Asked) -> Iterator[Case]:
    for j in asked.moving if len(asked.moving) > 1 else ():
        for factor, unit in UNITS.items():
            words = f"the effort of {asked.joints[j]} is in {unit}{_off(asked, (j,))}"
            yield words, Change(factor=asked.where({j: factor})), (j,)


def _unknown_unit(asked: Asked) -> Iterator[Case]:
    known = asked.ratio[np.isfinite(asked.ratio)]
    common = float(np.median(known)) if len(known) > 1 else 1.0
    listed = np.log([1.0, *UNITS])
    if np.abs(np.log(common) - listed).min() > KINDS[0].spread and abs(np.log(common)) > FAR:
        words = (
            f"the efforts are in a unit that is not stated, all off by about {digits(common, 2)}{_off(asked)}"
        )
        yield words, Change(factor=np.full(asked.robot.dof, common)), tuple(asked.moving)


def _groups(asked: Asked) -> Iterator[Case]:
    n, known = asked.robot.dof, np.isfinite(asked.ratio)
    for k in range(2, n - 1):
        for group, others in ((range(k), range(k, n)), (range(k, n), range(k))):
            if not known[list(others)].any():  # all that is known is off alike: that is the unit of all
                continue
            yield from _off_alike(
                asked, tuple(group), "the efforts of {} are off by a common factor of about {}"
            )


def _gears(asked: Asked) -> Iterator[Case]:
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


def _constants(asked: Asked) -> Iterator[Case]:
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


def _motor_side(asked: Asked) -> Iterator[Case]:
    if not asked.torques or asked.servo:
        return
    stated = np.abs(asked.robot.gear_ratio)
    for ratio in [stated] if np.any(stated != 1.0) else [np.full(asked.robot.dof, ratio) for ratio in GEARS]:
        words = f"the torques are the motors', before gears of about {digits(float(np.median(ratio)), 2)}"
        yield words, Change(factor=ratio), tuple(asked.moving)


def _servo_gains(asked: Asked) -> Iterator[Case]:
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


def _another_arm(asked: Asked) -> Iterator[Case]:
    change = Change(factor=np.full(asked.robot.dof, np.nan))
    yield f"another arm than {asked.robot.name} was recorded", change, tuple(asked.moving)


def _no_gravity(asked: Asked) -> Iterator[Case]:
    if np.any(asked.robot.gravity):
        words = "the efforts lack the weight of the arm: gravity is compensated"
        yield words, Change(gravity=np.zeros(3)), tuple(asked.moving)


def _upside_down(asked: Asked) -> Iterator[Case]:
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


GIVE = "give their columns the other way round: column in a preset, or --columns"
ORDER = "give the columns in the robot's order"
TURN = "turn it: sign = -1 in a preset, or the sign of [drive] gain, or the axis of the joint"
TURN_POSITION = "turn it: [position] sign in a preset, or the axis in the robot's description"
UNIT = (
    "state it: --degrees, or [position] unit in a preset; import without --degrees where they are in radians"
)
TRAVEL = 'state it: [position] unit = "%" in a preset'
SCALE = "state it: [position] scale in a preset"
STATE = "state it: [current] or [torque] unit in a preset, or [drive] gain"
GRAVITY = "state it: gravity in robot.toml"
NO_GRAVITY = "state it: gravity = [0, 0, 0] in robot.toml"
MOTOR_SIDE = "state [drive] gear_ratio in robot.toml, and import with --motor-side torque"
SERVO = "state it: [drive] gain in robot.toml"

TABLE = (
    Mistake("exchanged_columns", 0.004, GIVE, _exchanges(True, True, "all columns")),
    Mistake("exchanged_positions", 0.002, GIVE, _exchanges(True, False, "the positions")),
    Mistake("exchanged_efforts", 0.002, GIVE, _exchanges(False, True, "the efforts")),
    Mistake("order", 0.004, ORDER, _orders),
    Mistake("exchanged_chains", 0.003, ORDER, _chains),
    Mistake("position_sign", 0.004, TURN_POSITION, _turned_positions, of_sign=True),
    Mistake("position_unit", 0.005, UNIT, _angles),
    Mistake("percent_of_travel", 0.004, TRAVEL, _travel, always=True),
    Mistake("position_scale", 0.002, SCALE, _scales),
    Mistake("effort_sign", 0.005, TURN, _turned_efforts(1), of_sign=True),
    Mistake("two_effort_signs", 0.001, TURN, _turned_efforts(2), of_sign=True),
    Mistake("all_effort_signs", 0.005, TURN, _all_turned, of_sign=True),
    Mistake("effort_unit", 0.01, STATE, _effort_units),
    Mistake("one_effort_unit", 0.002, STATE, _one_effort_unit),
    Mistake("unknown_effort_unit", 0.001, STATE, _unknown_unit),
    Mistake("effort_group", 0.001, STATE, _groups),
    Mistake("gear_ratio", 0.002, STATE, _gears),
    Mistake("torque_constants", 0.004, STATE, _constants),
    Mistake("motor_side", 0.008, MOTOR_SIDE, _motor_side),
    Mistake("servo_gain", 0.02, SERVO, _servo_gains),
    Mistake("another_arm", 0.005, "give the description of the arm that was recorded", _another_arm),
    Mistake("no_gravity", 0.004, NO_GRAVITY, _no_gravity),
    Mistake("upside_down", 0.003, GRAVITY, _upside_down, physical=True, of_sign=True),
)
"""All kinds. Each prior is how many logs in a thousand have it, by what people report; together a twelfth."""
MOUNTING = Mistake("mounting", 0.01, GRAVITY, lambda asked: iter(()), physical=True)
"""An arm that stands otherwise: its direction takes a search, made where much is not explained."""
