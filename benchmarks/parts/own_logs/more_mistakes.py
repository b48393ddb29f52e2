"""Further mistakes: what a log says of another scale, another physics, another chain, or another time."""

from dataclasses import replace

import numpy as np

from .arms import SERVO, SIX, fourier, torques
from .mistakes import IMPORT, INIT, Mistake, Step, each, exchanged, times
from .scenes import (
    KP,
    Columns,
    Scene,
    cobot,
    followed,
    joint_torques,
    legs,
    numbered,
    servos,
    six,
)

MASS, CENTER = 2.0, (0.03, 0.14, 0.0)
"""Body on the flange [kg], [m]."""
WRONG_MASS = 1.6
"""Mass that is stated for it [kg]."""
QUARTER = r"\b0?\.2[45]\d*\b(?! ?(rad|N|m|Hz|s|A)\b)|\b(4(\.0\d*)?|3\.9\d*) times|quarter|a fourth|\b1/4\b"
"""How a scale of 1/4 is written, or its inverse."""
TWO = r"\b(2\.0\d*|1\.9\d*|2) (±|\+-|kg)"
"""How a mass of 2 kg is written."""


def _without_gravity(columns: Columns) -> Columns:
    """The same motion with torques that lack the weight of the arm."""
    return dict(joint_torques(SIX, 30.0, 100.0, 0.35, seed=3, gravity=False).columns)


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


def _lost_sign(values: np.ndarray) -> np.ndarray:
    """Registers of 16 bits read without their sign, then times 2.69 mA a step, in ampere."""
    return np.round(values / 0.00269) % 2.0**16 * 0.00269


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


def in_mujoco() -> Scene:
    """The servo arm by an MJCF whose servos are as in the log."""
    servo = f'kp="{KP}" forcerange="-3.35 3.35"'
    return replace(servos(), arm=SERVO.mjcf(servo, 'damping="0" armature="0.02"'), robot="")


def _stiff_mjcf() -> str:
    return SERVO.mjcf('kp="998" kv="2.7" forcerange="-3.35 3.35"', 'damping="0" armature="0.02"')


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
    Mistake("torques without gravity", _without_gravity, (GRAVITY_ABSENT,), six),
    Mistake(
        "torques of joints 4 to 6 times 10",
        times(10.0, r"tau[456]"),
        (JOINTS_4_TO_6, r"torque|effort|\btau", TEN),
        six,
    ),
    Mistake("positions times 1/4", times(0.25, r"q\d"), ("positions?|angles?", QUARTER, SCALE), six),
    Mistake("position of joint 5 times 1/4", times(0.25, "q5"), ("joint5", "position|angle", QUARTER), six),
    Mistake(
        "positions in per cent of travel",
        _per_cent,
        (r"(per ?cent|%) of (the |each |a )?(joints?'?s? )?(range|travel)|normali[sz]ed",),
        servos,
    ),
    Mistake(
        "legs in another order",
        exchanged(*((f"{s}{a}", f"{s}{a + 3}") for s in ("q", "tau") for a in (1, 2, 3, 7, 8, 9))),
        (
            r"FL.{0,120}FR|order of joints +4, 5, 6, 1, 2, 3, 10",
            r"exchanged|order|swapped|legs|chains|other way round",
        ),
        legs,
        steps=(INIT, IMPORT),
    ),
    Mistake(
        "gear ratio of joint 4 is half",
        _motor_side,
        (GEAR_OF_4,),
        six,
        robot=GEARS,
        options=("--motor-side",),
    ),
    Mistake(
        "a sign lost before scaling",
        each(_lost_sign, r"i\d"),
        (r"\bsigns?\b", r"lost|put back|restored|65[.,]?536|16 bits|two bands"),
    ),
    Mistake(
        "position register of joint 2 that saturates",
        each(_saturated, "q2"),
        (
            "joint2|q2",
            r"saturat|clipp|ends? at|end of (its |the )?(range|register)|stays at|stuck|constant at",
        ),
        six,
    ),
    Mistake("commands that are the next state", _next_state, ("command|action", NEXT), servos),
    Mistake("commands that are steps", _steps, ("command|action", STEPS), servos),
    Mistake(
        "no effort measured",
        times(0.0, r"tau\d"),
        (UNMEASURED,),
        six,
    ),
    Mistake(
        "a body on the flange that nobody states",
        times(1.0),
        (TWO, "payload|body|flange"),
        six,
        steps=(IMPORT, LOADED, WITH_PAYLOAD),
        others={"loaded": _loaded},
    ),
    Mistake(
        "a payload stated with a wrong mass",
        times(1.0),
        (TWO, r"\b1\.60?\b", "mass|kg"),
        six,
        steps=(IMPORT, LOADED, (*WITH_PAYLOAD, "--mass", str(WRONG_MASS), "--com", *map(str, CENTER))),
        others={"loaded": _loaded},
    ),
    Mistake(
        "torques that are multiplied by the drive gain again",
        lambda columns: (
            columns | {f"i{j + 1}": columns[f"i{j + 1}"] * gain for j, gain in enumerate(cobot().known.gain)}
        ),
        (AGAIN,),
    ),
    Mistake("stamps of arrival in bursts", each(_burst, "t"), (r"burst|arriv",), six),
    Mistake(
        "two runs in one file",
        _two_runs,
        (r"two runs|(time|stamps?) (begins?|starts?) (anew|again)|restarts?",),
        six,
        steps=(INIT, FOLDER),
    ),
    Mistake(
        "servo gain of an MJCF is 998, not 18",
        times(1.0),
        (r"\b998\b", r"\b1[678](\.\d+)?\b"),
        in_mujoco,
        robot=_stiff_mjcf(),
        steps=(INIT, IMPORT, OTHER, GAP),
        others={"other": _other_motion},
    ),
)
"""Further mistakes."""
