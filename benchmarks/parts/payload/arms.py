"""Arms whose payloads are weighed in simulation: from a desk arm with servos to a foundry robot."""

from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import EFFECTS, Prior, RigidBody
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model

from ..real.data import FOLDER


@dataclass(frozen=True)
class Arm:
    """An arm and the payloads that it carries."""

    name: str  # Name in the tables
    source: str  # Built-in name, or path in the folder of data
    masses: tuple[float, ...]  # Payloads [kg]
    size: float  # Distance of a payload's points from the flange [m]
    # Rated torque of each joint, which scales friction [N m]; 0 if the file states friction
    torque: tuple[float, ...] = ()
    # Drive gain of each joint [N m/A]; 0 if torque is measured, or if the file states gains
    gain: float = 0.0
    speed: float = 0.0  # Largest velocity [rad/s], if the file states no limits

    @property
    def there(self) -> bool:
        """Whether its file is."""
        return not self.torque or (FOLDER / self.source).exists()

    @property
    def measures_torque(self) -> bool:
        """Whether it has torque sensors."""
        return bool(self.torque) and not self.gain

    def model(self) -> Model:
        """Description of the arm, with tolerances of 10 % for links and gains unless the file states them."""
        if not self.torque:
            return read_model(self.source)
        model = read_model(FOLDER / self.source)
        n, rated = model.robot.dof, np.array(self.torque)
        limits = model.robot.limits
        reach = np.clip(limits.position_lower, -np.pi, 0.0), np.clip(limits.position_upper, 0.0, np.pi)
        fast = self.speed * np.ones(n)
        robot = replace(
            model.robot,
            limits=Limits(*reach, fast, 5.0 * fast, 50.0 * fast, np.full(n, np.inf)),
            drive_gain=np.full(n, self.gain or 1.0),
            inertial_tolerance=0.1,
            inertias_stated=True,
        )
        names = ("rotor_inertia", "viscous_friction", "coulomb_friction", "current_offset")
        plain = Model(robot, (RigidBody(), *(EFFECTS[name]() for name in names)))
        return replace(plain, stated=_friction(plain, rated, fast))


def _friction(model: Model, rated: np.ndarray, fast: np.ndarray) -> dict[str, Prior]:
    """Friction of 3 % of the rated torque, as much again at full speed, and rotors that take 5 % of it."""
    sizes = {"Fc": 0.03 * rated, "Fv": 0.03 * rated / fast, "Ia": 0.01 * rated / fast}
    stated = {
        f"{name}{joint + 1}": Prior(float(value), 0.3 * float(value))
        for name, values in sizes.items()
        for joint, value in enumerate(values)
    }
    offsets = {f"Off{joint + 1}": Prior(0.0, 0.01 * float(value)) for joint, value in enumerate(rated)}
    return {name: prior for name, prior in (stated | offsets).items() if name in model.names}


ARMS = (
    Arm("cobot (UR10)", "cobot", (0.5, 3.0, 10.0), 0.12),
    Arm("Panda", "mjcf/panda_nohand.xml", (0.7, 3.0), 0.08, (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0), 0.0,
        2.0),
    Arm("KR270", "kr270", (50.0, 175.0), 0.25),
    Arm("SO-100", "mjcf/so_arm100.xml", (0.2,), 0.04, (3.0, 3.0, 3.0, 3.0, 3.0, 3.0), 1.2, 3.0),
)  # fmt: skip
