"""24 real arms: six models as users have them, four arms of each, the same every time.

Three of them have nothing concealed, so every number that is changed there is changed for nothing. The
values of the others are drawn with the name of the arm as the seed. Half of the logs hold the motors'
torque; the others hold commands and positions alone, some at 50 Hz as of hobby servos.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np

from exidyn.identification.model import Model

from .concealed import described
from .draws import Usual, drawn
from .motions import FAST
from .physics import Item
from .real_arm import RealArm
from .saturation import sizing_motion, with_limits

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
