"""Mistakes that people make with their logs, each in a recording that is right without it.

A mistake's cure is named if the words of one of its patterns stand close together in what init, import,
identify or gap print about it, and not in what they print about the right log. The second half: what a log
says of another scale, another physics, another chain, or another time.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from .arms import (
    KP,
    SERVO,
    SIX,
    Columns,
    Scene,
    cobot,
    followed,
    fourier,
    joint_torques,
    legs,
    numbered,
    servos,
    six,
    torques,
)

Step = tuple[str, ...]
"""Words of one command; {folder}, {log}, {arm} and {robot} in them stand for paths."""
INIT: Step = tuple(
    "init {log} --robot {arm} -o {folder}/init/robot.toml --preset {folder}/init/preset.toml "
    "--json {folder}/init/init.json".split()
)
IMPORT: Step = tuple("import {log} --robot {robot} -o {folder}/run.mcap".split())
IDENTIFY: Step = tuple("identify {folder}/run.mcap -o {folder}/fit".split())
WALK = (INIT, IMPORT, IDENTIFY)


@dataclass(frozen=True)
class Mistake:
    """One mistake."""

    name: str  # In the table
    make: Callable[[Columns], Columns]  # Changes the columns of the right log
    says: tuple[str, ...]  # Patterns that must all stand close together in what names the cure
    scene: Callable[[], Scene] = cobot  # The right log
    robot: str = ""  # Built-in robot, or text of robot.toml, stated in place of the right one
    options: tuple[str, ...] = ()  # Further options of import
    steps: tuple[Step, ...] = WALK  # Commands
    # Makes further logs by their names, as a second run
    others: dict[str, Callable[[], Columns]] = field(default_factory=dict)


def exchanged(*pairs: tuple[str, str]) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        changed = dict(columns)
        for a, b in pairs:
            changed[a], changed[b] = columns[b], columns[a]
        return changed

    return make


def times(factor: float, *names: str) -> Callable[[Columns], Columns]:
    return each(lambda values: values * factor, *names)


def each(change: Callable[[np.ndarray], np.ndarray], *names: str) -> Callable[[Columns], Columns]:
    def make(columns: Columns) -> Columns:
        matched = [name for name in columns if any(re.fullmatch(one, name) for one in names)]
        return columns | {name: change(columns[name]) for name in matched}

    return make


def register(bits: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda values: np.round(values * 1000.0) % 2.0**bits / 1000.0


def _sign_bit(bit: int) -> Callable[[np.ndarray], np.ndarray]:
    def change(values: np.ndarray) -> np.ndarray:
        counts = np.round(values * 0.9 * 2**bit / np.abs(values).max())
        scale = np.abs(values).max() / (0.9 * 2**bit)
        return scale * np.where(counts < 0, 2.0**bit - counts, counts)

    return change


def _counted(steps: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda values: np.round(values * steps / (2 * np.pi))


def _held(times: int, *names: str) -> Callable[[Columns], Columns]:
    return each(lambda values: np.repeat(values[::times], times)[: len(values)], *names)


def in_order(*joints: int) -> Callable[[Columns], Columns]:
    """Columns of these joints in the place of joints 1 to n."""
    pairs = [(s, j, other) for s in ("q", "dq", "i") for j, other in enumerate(joints, 1)]
    return lambda columns: columns | {f"{s}{j}": columns[f"{s}{other}"] for s, j, other in pairs}


def _same_stamp(columns: Columns) -> Columns:
    time = columns["t"].copy()
    time[1000] = time[999]
    return columns | {"t": time}


def _two_sources(columns: Columns) -> Columns:
    """Between all rows one of zeros with the same stamp and without effort."""
    mixed = {}
    for name, values in columns.items():
        other = values if name == "t" else np.full(len(values), np.nan if name.startswith("i") else 0.0)
        mixed[name] = np.column_stack([values, other]).ravel()
    return mixed


def _turned(columns: Columns) -> Columns:
    """Joints 1 and 2 to 0 ... 360 degrees; joint 1 passes through zero."""
    return columns | {f"q{j}": np.mod(columns[f"q{j}"], 2 * np.pi) for j in (1, 2)}


def without(signal: str) -> Callable[[Columns], Columns]:
    return lambda columns: {
        name: values for name, values in columns.items() if not re.fullmatch(signal, name)
    }


EXCHANGED = r"exchanged|other way round|interchanged|swapped"
AGAINST = r"against|other way|opposite|negated|reversed|negative|turn"
EFFORT = r"current|effort|torque"
PER_THOUSAND = r"(?-i:\bmA\b)|thousandth|milli|\b1000\b|\b0?\.001\d?\b|1e-0?3"
MISTAKES = (
    Mistake("positions of joints 1 and 2 exchanged", exchanged(("q1", "q2")),
        (rf"positions? .*joint1 and joint2.*({EXCHANGED})|position .*column.*q2, ?q1|q2, q1, q3",)),
    Mistake("columns of joints 1 and 2 exchanged", exchanged(("q1", "q2"), ("i1", "i2"), ("dq1", "dq2")),
        (rf"joint1 and joint2.*({EXCHANGED})|order of joints +2, 1, 3",)),
    Mistake("currents of joints 2 and 3 exchanged", exchanged(("i2", "i3")),
        (rf"(efforts?|currents?) .*joint2 and joint3.*({EXCHANGED})|i1, i3, i2",)),
    Mistake("columns of joints 4 and 6 exchanged", exchanged(("q4", "q6"), ("i4", "i6"), ("dq4", "dq6")),
        (rf"joint4 and joint6.*({EXCHANGED})|order of joints +1, 2, 3, 6, 5, 4",)),
    Mistake("joints in reverse order", in_order(6, 5, 4, 3, 2, 1),
        (r"reverse(d)? order|order of joints +6, 5, 4, 3, 2, 1",)),
    Mistake("joints one late", in_order(6, 1, 2, 3, 4, 5),
        (r"(begin|start|are|is) one (joint )?(late|early)|order of joints +2, 3, 4, 5, 6, 1",)),
    Mistake("current of joint 1 negated", times(-1.0, "i1"), ("joint1", AGAINST)),
    Mistake("current of joint 3 negated", times(-1.0, "i3"),
        (rf"joint3\b.{{0,40}}({AGAINST})|gain of joint3 +-",)),
    Mistake("all currents negated", times(-1.0, r"i\d"),
        (rf"all ({EFFORT})s? .*({AGAINST})|gain of joint2 +-",)),
    Mistake("position of joint 3 negated", times(-1.0, "q3", "dq3"),
        (rf"joint3\b.{{0,40}}({AGAINST})|gain of joint3 +-",)),
    Mistake("currents in mA", times(1000.0, r"i\d"), (PER_THOUSAND, EFFORT)),
    Mistake("current of joint 3 in mA", times(1000.0, "i3"), (PER_THOUSAND, "joint3")),
    Mistake("currents in per cent", times(100.0 / 20.0, r"i\d"),
        (r"per ?cent|in a unit|unit that is not (known|stated)|off by|factor|times", EFFORT)),
    Mistake("positions in degrees", times(180 / np.pi, r"q\d"), (r"in degrees|position +deg\b|--degrees",)),
    Mistake("position of joint 3 in degrees", times(180 / np.pi, "q3"), ("joint3|q3", r"degrees|\bdeg\b")),
    Mistake("radians taken for degrees", times(1.0), (r"without (--)?degrees|(are|in) radians",),
        options=("--degrees",)),
    Mistake("milliseconds", times(1000.0, "t"), (r"time-scale|unit of time +ms\b|milliseconds",)),
    Mistake("positions in counts", each(_counted(65536), r"q\d"),
        (r"\bin counts|counts of|ticks|steps of (an |the )?encoder|steps a turn",)),
    Mistake("joints 1 and 2 from 0 to 360 degrees", _turned, (r"full turns?|wrap|360", r"q1|joint1")),
    Mistake("currents of 16 bits without sign", each(register(16), r"i\d"),
        (r"\bsigns?\b", r"16 bits|65[.,]?536|lost")),
    Mistake("current of joint 2, sign in bit 10", each(_sign_bit(10), "i2"),
        ("sign", r"i2|joint2", r"\bbit|lost|1024")),
    Mistake("another robot", times(1.0), (r"another (arm|robot)|(other|different) (arm|robot) than",),
        robot="kr270"),
    Mistake("one stamp twice", _same_stamp,
        (r"not increase|same (stamp|time)|repeated? (stamp|time)|stamps? twice",)),
    Mistake("two publishers", _two_sources, (r"two (sources|publishers)",)),
    Mistake("every sample ten times", _held(10, r"d?q\d", r"i\d"),
        (r"repeat|same sample|held|ten times|10 times",)),
    Mistake("velocities in degrees a second", times(180 / np.pi, r"dq\d"), ("velocit", r"\bdeg|derivative")),
    Mistake("velocity of joint 2 is that of joint 4", exchanged(("dq2", "dq4")),
        ("velocit", "derivative", r"joint2|dq2|joint4|dq4")),
    Mistake("no positions", without(r"q\d"),
        (r"no (column of |columns of )?position|position.{0,60}(not|missing|needed)|q1.*(missing|needed)",)),
)  # fmt: skip
"""Mistakes in columns, units and clocks."""


MASS, CENTER = 2.0, (0.03, 0.14, 0.0)
"""Body on the flange [kg], [m]."""
WRONG_MASS = 1.6
"""Mass that is stated for it [kg]."""
QUARTER = r"\b0?\.2[45]\d*\b(?! ?(rad|N|m|Hz|s|A)\b)|\b(4(\.0\d*)?|3\.9\d*) times|quarter|a fourth|\b1/4\b"
"""How a scale of 1/4 is written, or its inverse."""
TWO = r"\b(2\.0\d*|1\.9\d*|2) (±|\+-|kg)"
"""How a mass of 2 kg is written."""


def _per_cent(columns: Columns) -> Columns:
    """Positions and commands of 0 at the middle and 100 at the end of each joint's range."""
    return {
        name: values if name == "t" else 100 * (values - SERVO.middle[int(name[-1]) - 1]) / SERVO.reach
        for name, values in columns.items()
    }


SERVO_NUMBERS = range(1, len(SERVO.bodies) + 1)
GEAR = 0.5
"""True gear ratio of joint 4 over the one stated."""


def _motor_side(columns: Columns) -> Columns:
    """Positions and torques of the motors behind gears of 100, but of 50 at joint 4."""
    ratios = np.full(len(SIX.bodies), 100.0)
    ratios[3] *= GEAR
    motor = dict(columns)
    for joint, ratio in enumerate(ratios, 1):
        motor |= {f"q{joint}": columns[f"q{joint}"] * ratio, f"tau{joint}": columns[f"tau{joint}"] / ratio}
    return motor


def _saturated(values: np.ndarray) -> np.ndarray:
    """Positions of a register that ends at three quarters of the motion."""
    middle, reach = np.mean([values.min(), values.max()]), np.ptp(values) / 2
    return np.clip(values, middle - 0.75 * reach, middle + 0.75 * reach)


def _next_state(columns: Columns) -> Columns:
    """Commands that a converter copied from the positions of the next sample."""
    return columns | {
        f"q_ref{j}": np.append(columns[f"q{j}"][1:], columns[f"q{j}"][-1]) for j in SERVO_NUMBERS
    }


def _steps(columns: Columns) -> Columns:
    """Commands that are relative to the position."""
    return columns | {f"q_ref{j}": columns[f"q_ref{j}"] - columns[f"q{j}"] for j in SERVO_NUMBERS}


def _burst(stamps: np.ndarray) -> np.ndarray:
    """Stamps of messages that arrive by five, 0.2 ms apart."""
    place = np.arange(len(stamps))
    return stamps[np.minimum(place // 5 * 5 + 4, len(stamps) - 1)] + 0.0002 * (place % 5)


def _two_runs(columns: Columns) -> Columns:
    """Two pieces in one file that do not follow each other, each with a time that begins at zero."""
    count = len(columns["t"])
    first, second = np.arange(2 * count // 5), np.arange(3 * count // 5, count)
    pieces = {name: (values[first], values[second]) for name, values in columns.items()}
    pieces["t"] = tuple(stamps - stamps[0] for stamps in pieces["t"])
    return {name: np.concatenate(pair) for name, pair in pieces.items()}


def _loaded() -> Columns:
    arm = SIX.loaded(MASS, CENTER)
    motion = fourier(arm.middle, np.arange(0.0, 30.0, 0.01), 11, 0.35)
    return numbered(t=motion.time, q=motion.position, tau=torques(arm, motion))


def _other_motion() -> Columns:
    time, position, command = followed(seed=7, seconds=20.0)
    return numbered(t=time, q=position, q_ref=command)


def _times_gain(columns: Columns) -> Columns:
    gains = enumerate(cobot().known.gain, 1)
    return columns | {f"i{joint}": columns[f"i{joint}"] * gain for joint, gain in gains}


LIMITED, PASSIVE = 'forcerange="-3.35 3.35"', 'damping="0" armature="0.02"'


def in_mujoco() -> Scene:
    """The servo arm by an MJCF whose servos are as in the log."""
    return replace(servos(), arm=SERVO.mjcf(f'kp="{KP}" {LIMITED}', PASSIVE), robot="")


LOADED: Step = tuple("import {folder}/loaded.csv --robot {robot} -o {folder}/loaded.mcap".split())
WITH_PAYLOAD: Step = tuple(
    "identify {folder}/run.mcap --payload {folder}/loaded.mcap -o {folder}/fit".split()
)
OTHER: Step = tuple(
    "import {folder}/other.csv --robot {robot} -o {folder}/other.mcap --effort command".split()
)
GAP: Step = tuple("gap {robot} {folder}/run.mcap --validate {folder}/other.mcap -o {folder}/gap".split())
GEARS = 'format = 1\nurdf = "arm.urdf"\n[drive]\ngear_ratio = 100\n'
GRAVITY_ABSENT = (
    r"(lack|without|miss|compensat|contain no|hold no).{0,60}(gravity|weight)"
    r"|(gravity|weight).{0,60}(compensat|missing|absent|not in|left out|no part|\[?0(\.0)?, 0(\.0)?, 0)"
)
JOINTS_4_TO_6 = r"(?<!joint3, )joint4.{0,30}joint6|joints 4 (to|-) 6"
TEN = r"\b(10|9\.\d+|0?\.1\d?|0?\.09\d*)\b|tenth|unit"
GEAR_OF_4 = r"joint4.{0,60}(gear|\b0?\.5\d?\b|\b2(\.0\d*)? times|twice|half)|(gear|twice|half).{0,60}joint4"
SCALE = r"scale|times|factor|look as if|share|of the angle|multipl|unit"
STEPS = r"\bsteps\b|increment|delta|differences"
ONE = "(sample|state|frame|row|step|position)"
NEXT = rf"next {ONE}|one {ONE} (early|earlier|later|ahead)|copied|no error"
UNMEASURED = r"no (effort|torque)s? (was|were|is) measured|all (effort|torque)s? are (0|zero)"
AGAIN = (
    r"already|twice|again|\bare (joint )?torques|torques? of the joints?\b|in N m\b|of i\S* +N m of the joint"
)


FOLDER: Step = (*IMPORT[:-1], "{folder}/runs")
MORE = (
    Mistake("torques without gravity",
        lambda _: dict(joint_torques(SIX, 30.0, 100.0, 0.35, seed=3, gravity=False).columns),
        (GRAVITY_ABSENT,), six),
    Mistake("torques of joints 4 to 6 times 10", times(10.0, r"tau[456]"),
        (JOINTS_4_TO_6, r"torque|effort|\btau", TEN), six),
    Mistake("positions times 1/4", times(0.25, r"q\d"), ("positions?|angles?", QUARTER, SCALE), six),
    Mistake("position of joint 5 times 1/4", times(0.25, "q5"), ("joint5", "position|angle", QUARTER), six),
    Mistake("positions in per cent of travel", _per_cent,
        (r"(per ?cent|%) of (the |each |a )?(joints?'?s? )?(range|travel)|normali[sz]ed",), servos),
    Mistake("legs in another order",
        exchanged(*((f"{s}{a}", f"{s}{a + 3}") for s in ("q", "tau") for a in (1, 2, 3, 7, 8, 9))),
        (r"FL.{0,120}FR|order of joints +4, 5, 6, 1, 2, 3, 10",
         r"exchanged|order|swapped|legs|chains|other way round"),
        legs, steps=(INIT, IMPORT)),
    Mistake("gear ratio of joint 4 is half", _motor_side, (GEAR_OF_4,), six, robot=GEARS,
        options=("--motor-side",)),
    Mistake("a sign lost before scaling",   # registers of 16 bits, then times 2.69 mA a step, in ampere
        each(lambda i: np.round(i / 0.00269) % 2.0**16 * 0.00269, r"i\d"),
        (r"\bsigns?\b", r"lost|put back|restored|65[.,]?536|16 bits|two bands")),
    Mistake("position register of joint 2 that saturates", each(_saturated, "q2"),
        ("joint2|q2",
         r"saturat|clipp|ends? at|end of (its |the )?(range|register)|stays at|stuck|constant at"),
        six),
    Mistake("commands that are the next state", _next_state, ("command|action", NEXT), servos),
    Mistake("commands that are steps", _steps, ("command|action", STEPS), servos),
    Mistake("no effort measured", times(0.0, r"tau\d"), (UNMEASURED,), six),
    Mistake("a body on the flange that nobody states", times(1.0), (TWO, "payload|body|flange"), six,
        steps=(IMPORT, LOADED, WITH_PAYLOAD), others={"loaded": _loaded}),
    Mistake("a payload stated with a wrong mass", times(1.0), (TWO, r"\b1\.60?\b", "mass|kg"), six,
        steps=(IMPORT, LOADED, (*WITH_PAYLOAD, "--mass", str(WRONG_MASS), "--com", *map(str, CENTER))),
        others={"loaded": _loaded}),
    Mistake("torques that are multiplied by the drive gain again",
        _times_gain, (AGAIN,)),
    Mistake("stamps of arrival in bursts", each(_burst, "t"), (r"burst|arriv",), six),
    Mistake("two runs in one file", _two_runs,
        (r"two runs|(time|stamps?) (begins?|starts?) (anew|again)|restarts?",), six, steps=(INIT, FOLDER)),
    Mistake("joints 2 and 5 count the other way", times(-1.0, "(q|tau)[25]"),
        ("joint2 (counts the other|sign)", "joint5 (counts the other|sign)"), six),
    Mistake("elbow and ground", lambda c: c | {"q3": c["q3"] + c["q2"]}, ("joint3 is the sum of",), six),
    Mistake("joint 5 is a difference, with its efforts", lambda c: c | {"q5": c["q5"] - c["q4"],
        "tau4": c["tau4"] + c["tau5"]}, ("joint5 is the difference of joint5 and joint4",), six),
    Mistake("a differential wrist", lambda c: c | {"q5": c["q5"] + c["q6"], "q6": c["q5"] - c["q6"]},
        ("joint5 and joint6 are sum and difference",), six),
    Mistake("efforts with a clock of their own", lambda c: c | {f"tau{j}": np.interp(0.99 * c["t"], c["t"],
        c[f"tau{j}"]) for j in range(1, 7)}, ("two clocks .*1.0",), six),
    Mistake("a push", lambda c: c | {f"tau{j}": c[f"tau{j}"] + 50 / j * (abs(c["t"] - 5) < 0.7)
        for j in (1, 2, 3)}, ("joints leave the model together",), six),
    Mistake("servo gain of an MJCF is 998, not 18", times(1.0), (r"\b998\b", r"\b1[678](\.\d+)?\b"),
        in_mujoco, robot=SERVO.mjcf(f'kp="998" kv="2.7" {LIMITED}', PASSIVE),
        steps=(INIT, IMPORT, OTHER, GAP),
        others={"other": _other_motion}),
)  # fmt: skip
"""Further mistakes."""
