"""24 real arms: six models as users have them, four arms of each, the same every time.

Three of them have nothing concealed, so every number that is changed there is changed for nothing. The values
of the others are drawn with the name of the arm as the seed, large enough to matter and no arm absurd. Half
of the logs hold the motors' torque; the others hold commands and positions alone, some at 50 Hz.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from zlib import crc32

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import LAW, servo_of, servo_words, with_servo_error
from exidyn.trajectories.random_motion import random_fourier

from .concealed import described
from .real_arm import Item, Motion, RealArm, Values, temperature


class Usual(NamedTuple):
    """What one joint of the original file does in a random motion."""

    torque: float  # RMS torque of the motor [N m]
    friction: float  # Smallest torque that counts: the file's friction, or a share of `torque` [N m]
    velocity: float  # RMS velocity [rad/s]
    inertia: float  # Inertia that the joint moves at the file's reference pose, with the rotor [kg m^2]


Draw = Callable[[np.random.Generator, Usual], Values]


def _factor(draw: np.random.Generator, lower: float, upper: float) -> float:
    """A factor between two, or its inverse."""
    return float(draw.uniform(lower, upper) ** draw.choice((-1.0, 1.0)))


DRAWS: dict[str, Draw] = {
    "delay": lambda draw, usual: {"seconds": draw.uniform(0.005, 0.045)},
    "kp": lambda draw, usual: {"factor": _factor(draw, 1.3, 2.0)},
    "kv": lambda draw, usual: {"factor": _factor(draw, 1.4, 2.0)},
    "forcerange": lambda draw, usual: {"saturated": draw.uniform(0.03, 0.06)},
    "coulomb": lambda draw, usual: {"frictionloss": draw.uniform(1.0, 2.0) * usual.friction},
    "viscous": lambda draw, usual: {"damping": draw.uniform(0.7, 1.5) * usual.friction / usual.velocity},
    "armature": lambda draw, usual: {"armature": draw.uniform(0.5, 1.0) * usual.inertia},
    "stribeck": lambda draw, usual: {
        "torque": draw.uniform(1.5, 2.5) * usual.friction, "velocity": draw.uniform(0.08, 0.2),
    },
    "load": lambda draw, usual: {"mu": draw.uniform(0.1, 0.25)},
    "thermal": lambda draw, usual: {
        "damping": draw.uniform(1.5, 2.5) * usual.friction / usual.velocity,
        "beta": draw.uniform(0.04, 0.06), "rise": draw.uniform(15.0, 25.0), "tau": draw.uniform(6.0, 10.0),
    },
    "cable": lambda draw, usual: {
        "stiffness": draw.uniform(0.8, 1.2) * usual.friction, "reference": draw.uniform(-0.5, 0.5),
        "ripple": draw.uniform(0.5, 1.0) * usual.friction, "waves": float(draw.integers(6, 12)),
    },
    "spring": lambda draw, usual: {
        "stiffness": draw.uniform(0.2, 0.4) * usual.torque, "reference": draw.uniform(-0.5, 0.5),
    },
    "mass": lambda draw, usual: {"factor": draw.uniform(1.25, 1.6)},
    "tilt": lambda draw, usual: {
        "angle": np.radians(draw.uniform(3.0, 6.0)), "direction": draw.uniform(-np.pi, np.pi),
    },
    "gravcomp": lambda draw, usual: {"share": draw.uniform(0.7, 0.85)},
}  # fmt: skip
"""Kind of an item -> how its values are drawn. A thermal arm loses half of its warm-up friction in a run."""


def drawn(kind: str, joints: tuple[int, ...], usual: list[Usual], draw: Any) -> Item:
    """An item with values of the size that suits its first joint."""
    return Item(kind, joints, DRAWS[kind](draw, usual[joints[0] if joints else 0]))


SECONDS = 20.0
"""Duration of the motions that size items [s]."""
BISECTIONS = 7
REACHED = 0.999
"""Share of the limit that counts as the limit: torques are means over samples."""


def with_limits(path: Path, nominal: Model, items: list[Item]) -> tuple[Item, ...]:
    """Items in which the share of saturated samples, where there is any, has become a limit [N m]."""
    for index, item in enumerate(items):
        if item.kind == "forcerange":
            others = [*items[:index], *items[index + 1 :]]
            items[index] = _limited(path, nominal, item, others)
    return tuple(items)


def _limited(path: Path, nominal: Model, item: Item, others: list[Item]) -> Item:
    """The item with the limit that an arm with these other items reaches in the item's share of samples."""
    [joint], joints = item.joints, nominal.robot.joints
    unlimited = sizing_motion(RealArm(path, joints, others), nominal)
    lower, upper = 0.0, float(np.max(np.abs(unlimited.torque[:, joint])))
    for _ in range(BISECTIONS):
        limit = 0.5 * (lower + upper)
        arm = RealArm(path, joints, [*others, item._replace(values={"limit": limit})])
        too_low = _saturated(arm, nominal, joint, limit) > item.values["saturated"]
        lower, upper = (limit, upper) if too_low else (lower, limit)
    return item._replace(values={"limit": upper})


def _saturated(arm: RealArm, nominal: Model, joint: int, limit: float) -> float:
    """Share of the samples of all motions at the limit of a servo [-]."""
    motions = [sizing_motion(arm, nominal, seed) for seed in SEEDS.values()]
    torques = np.concatenate([np.abs(motion.torque[:, joint]) for motion in motions])
    return float(np.mean(torques > REACHED * limit))


def sizing_motion(arm: RealArm, nominal: Model, seed: int = 0) -> Motion:
    """The random motion of an arm by which items are sized."""
    return arm.follow(*commands(nominal.robot.limits, SECONDS, 1.0 / FAST, seed))


if TYPE_CHECKING:
    from .arms import Arm

FAST = 250.0
"""Sampling rate of industrial controllers [Hz]."""
TORQUE_NOISE = 0.01
"""Standard deviation of the logged torque over its rms [-]."""
SEEDS = {"identify": 0, HELD_OUT: 1, "third": 2}
"""Motion by its role: exidyn fits the first and decides by the second; the third judges."""
KELVIN = 0.1
"""Resolution of logged temperatures [K]."""


def commands(limits: Limits, seconds: float, period: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [s] and random commands (t, n) [rad] within limits."""
    time = np.arange(0.0, seconds, period)
    return time, random_fourier(limits, seconds, seed=seed).at(time).position


def moved(arm: "Arm", seconds: float, seed: int) -> Motion:
    """A random motion of a real arm."""
    return arm.real().follow(*commands(arm.nominal.robot.limits, seconds, 1.0 / arm.rate, seed))


def logged(arm: "Arm", motion: Motion, seed: int, name: str) -> Recording:
    """The log of a motion, as the arm's controller writes it."""
    random = np.random.default_rng(seed)
    torque = motion.torque + TORQUE_NOISE * np.sqrt(np.mean(motion.torque**2, axis=0)) * random.normal(
        size=motion.torque.shape
    )
    values = {
        "position": np.round(motion.position / arm.encoder) * arm.encoder,
        "command": motion.command,
        "torque": torque,
    }
    if arm.temperature:
        values["temperature"] = _temperatures(arm, motion.time)
    signals = {key: Signal(motion.time, value) for key, value in values.items()}
    run = Recording(name, arm.nominal, signals)
    return run if arm.log == "torque" else commands_alone(run)


def commands_alone(run: Recording) -> Recording:
    """The log without torque, as `exidyn import --effort command` reads it."""
    servo = servo_of(run.robot, None, None)
    signals = {name: signal for name, signal in run.signals.items() if name != "torque"}
    signals = with_servo_error(signals, servo, run.name)
    return Recording(run.name, run.model, signals, settings=dict(run.settings) | {LAW: servo_words(servo)})


def _temperatures(arm: "Arm", time: np.ndarray) -> np.ndarray:
    """Temperatures of all motors (t, n) [degC]; they warm alike."""
    [values] = [item.values for item in arm.items if item.kind == "thermal"]
    rounded = np.round(temperature(values, time) / KELVIN) * KELVIN
    return np.repeat(rounded[:, None], arm.nominal.robot.dof, axis=1)


TORQUE, COMMANDS = "torque", "commands"
SLOW = 50.0
"""Sampling rate of hobby servos [Hz]."""
FRICTION = 0.15
"""Share of a joint's rms torque that is its usual friction, where the file states less."""
COARSE = ("dynamixel_2r", "so_arm100")
"""Models whose servos have encoders of 4096 counts; others have 2^17."""


class Arm(NamedTuple):
    """A real arm and the logs that it leaves."""

    name: str  # Name of the arm
    path: Path  # Path of the user's file
    nominal: Model  # What the file describes
    items: tuple[Item, ...]  # What is concealed
    log: str  # Effort of its logs, `TORQUE` or `COMMANDS`
    rate: float = FAST  # Sampling rate [Hz]
    temperature: bool = False  # Whether logs hold the motors' temperatures

    @property
    def encoder(self) -> float:
        """Resolution of positions [rad]."""
        return 2.0 * np.pi / (2**12 if self.path.stem in COARSE else 2**17)

    def real(self) -> RealArm:
        """The arm in MuJoCo."""
        return RealArm(self.path, self.nominal.robot.joints, self.items)


class Row(NamedTuple):
    """One row of `TABLE`; items are written "kind joint", "kind all" or "kind base"."""

    model: str
    log: str
    items: tuple[str, ...] = ()
    rate: float = FAST
    temperature: bool = False


TABLE = (
    Row("dynamixel_2r", TORQUE),
    Row("dynamixel_2r", COMMANDS, ("delay all", "kp all")),
    Row("dynamixel_2r", TORQUE, ("coulomb 0", "load 1")),
    Row("dynamixel_2r", COMMANDS, ("kp 0", "viscous 1"), rate=SLOW),
    Row("ur10e", TORQUE, ("delay all", "thermal 1")),
    Row("ur10e", COMMANDS, ("kv 0", "mass 2")),
    Row("ur10e", TORQUE, ("cable 2",)),
    Row("ur10e", COMMANDS),
    Row("so_arm100", COMMANDS, ("delay all", "kp all"), rate=SLOW),
    Row("so_arm100", COMMANDS, ("forcerange 0",), rate=SLOW),
    Row("so_arm100", TORQUE, ("stribeck 1", "load 2")),
    Row("so_arm100", TORQUE, ("armature 0", "coulomb 2")),
    Row("panda_nohand", TORQUE, ("thermal 1",), temperature=True),
    Row("panda_nohand", TORQUE, ("kp 1", "spring 3")),
    Row("panda_nohand", COMMANDS, ("delay all", "viscous 1")),
    Row("panda_nohand", COMMANDS, ("kv 0", "mass 3")),
    Row("piper", TORQUE, ("gravcomp base",)),
    Row("piper", COMMANDS, ("delay 1", "forcerange 0")),
    Row("piper", TORQUE, ("stribeck 1", "cable 3")),
    Row("piper", COMMANDS, rate=SLOW),
    Row("iiwa14", TORQUE, ("delay all", "forcerange 0")),
    Row("iiwa14", COMMANDS, ("load 1",)),
    Row("iiwa14", TORQUE, ("tilt base", "armature 0")),
    Row("iiwa14", COMMANDS, ("kp 1", "cable 3")),
)
QUICK = (0, 1, 2, 3)
"""Rows of the quick run."""


def arms(folder: Path, rows: tuple[int, ...] = tuple(range(len(TABLE)))) -> Iterator[Arm]:
    """Real arms by rows of the table, of models in a folder."""
    for row in rows:
        number = 1 + sum(other.model == TABLE[row].model for other in TABLE[:row])
        yield _arm(f"{TABLE[row].model} {number}", folder, TABLE[row])


def _arm(name: str, folder: Path, row: Row) -> Arm:
    path, draw = folder / f"{row.model}.xml", np.random.default_rng(crc32(name.encode()))
    nominal = described(path)
    usual = _usual(path, nominal)
    joints = {"all": tuple(range(nominal.robot.dof)), "base": ()}
    items = []
    for kind, where in (words.split() for words in row.items):
        items.append(drawn(kind, joints.get(where) or _joint(where), usual, draw))
    return Arm(name, path, nominal, with_limits(path, nominal, items), row.log, row.rate, row.temperature)


def _joint(where: str) -> tuple[int, ...]:
    return (int(where),) if where.isdigit() else ()


def _usual(path: Path, nominal: Model) -> list[Usual]:
    """What each joint of the original file does in a random motion."""
    arm = RealArm(path, nominal.robot.joints, ())
    motion = sizing_motion(arm, nominal)
    torque, velocity = (np.sqrt(np.mean(values**2, axis=0)) for values in (motion.torque, motion.velocity))
    dofs = [place.dof for place in arm.places]
    friction = np.maximum(arm.model.dof_frictionloss[dofs], FRICTION * torque)
    numbers = zip(torque, friction, velocity, arm.model.dof_M0[dofs], strict=True)
    return [Usual(*map(float, row)) for row in numbers]
