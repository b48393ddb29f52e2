"""One robot of a concealed case: the arm as it is, its nominal model, and how it is recorded."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model

from .plant.body import Body, mass_matrix, turn
from .plant.friction import Machine, plain_friction

EARTH = np.array([0.0, 0.0, -9.81])


class Limits(NamedTuple):
    """What a motion may reach, each (n,) [rad, rad, rad/s, rad/s^2, N m]."""

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray


class Tool(NamedTuple):
    """A box on the flange: mass [kg], centre (3,) [m], edges (3,) [m]."""

    mass: float
    com: np.ndarray
    edges: np.ndarray

    @property
    def inertia(self) -> np.ndarray:
        """About its centre, (3, 3) [kg m^2]."""
        squares = self.edges**2
        return np.diag(self.mass / 12.0 * (np.sum(squares) - squares))


@dataclass(frozen=True)
class Arm:
    """An arm; per-joint arrays (n,), torques and angles at the joints."""

    name: str  # Of the robot
    body: Body  # Its links
    limits: Limits  # Of its motions
    home: np.ndarray  # Where it rests [rad]
    gain: np.ndarray  # Torque per current [N m / current unit]
    gear: np.ndarray  # Motor turns per joint turn [-]
    rotor: np.ndarray  # Inertia of the motors [kg m^2]
    viscous: np.ndarray  # Friction [N m s/rad]
    coulomb: np.ndarray  # Dry friction [N m]
    encoder: np.ndarray  # Step of a recorded position [rad]
    current: np.ndarray  # Step of a recorded current [current unit]
    floor: np.ndarray  # Standard deviation of what no model explains [N m]
    tool: Tool  # What its makers hang on it to identify it
    warm: bool  # Whether temperatures are recorded
    balancer: np.ndarray  # Joint, d21, d22, phi, Kr, K0; joint -1 is none

    @property
    def joints(self) -> int:
        """Their number."""
        return len(self.home)


NO_BALANCER = np.array([-1.0, 0.7, 0.2, 0.0, 0.0, 0.0])


def array(*values: float) -> np.ndarray:
    """Numbers as an array."""
    return np.array(values, float)


def axes(turn_x: float) -> np.ndarray:
    """Rotation about x, which is how one joint axis leans against the one before."""
    c, s = np.cos(turn_x), np.sin(turn_x)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def chain(quarter_turns: list, places: list, masses: list, coms: list, radii: list) -> Body:
    """Bodies from quarter turns about x, places [m], masses [kg], centres and radii of gyration [m]."""
    inertia = [m * np.diag(np.square(r)) for m, r in zip(masses, radii, strict=True)]
    return Body(
        np.array([axes(0.5 * np.pi * turns) for turns in quarter_turns]),
        np.array(places, float),
        np.array(masses, float),
        np.array(coms, float),
        np.array(inertia),
        EARTH.copy(),
    )


def kr270() -> Arm:
    """A heavy industrial arm with a spring balancer: numbers of exidyn's own robot file."""
    model = read_model("kr270")
    robot, stated = model.robot, dict(zip(model.names, model.nominal_values, strict=True))
    links = robot.kinematics.inertias[1:]
    places = robot.kinematics.jointPlacements[1:]
    body = Body(
        np.array([place.rotation for place in places]),
        np.array([place.translation for place in places]),
        np.array([link.mass for link in links]),
        np.array([link.lever for link in links]),
        np.array([link.inertia for link in links]),
        EARTH.copy(),
    )
    limits = robot.limits
    each = {name: np.array([stated[f"{name}{j}"] for j in range(1, 7)]) for name in ("Ia", "Fv", "Fc")}
    each["Ia"][0] += 500.0  # its first motor is as large as the second
    return Arm(
        name="kr270",
        body=body,
        limits=Limits(
            limits.position_lower, limits.position_upper, limits.velocity, limits.acceleration, limits.torque
        ),
        home=array(0.0, -1.25, 1.3, 0.0, 0.1, 0.0),
        gain=np.array(robot.drive_gain),
        gear=np.array(robot.gear_ratio),
        rotor=each["Ia"],
        viscous=each["Fv"],
        coulomb=each["Fc"],
        encoder=array(4e-6, 4e-6, 4e-6, 6e-6, 6e-6, 8e-6),
        current=np.full(6, 0.004),
        floor=array(24.0, 36.0, 22.0, 12.0, 14.0, 13.5),
        tool=Tool(62.0, array(0.05, -0.06, -0.18), array(0.4, 0.35, 0.3)),
        warm=True,
        balancer=array(1.0, 0.6964, 0.1847, -1.6148, stated["Kr"], stated["K0"]),
    )


def ur10like() -> Arm:
    """A lightweight arm of six joints."""
    body = chain(
        [0, 1, 0, 0, 1, -1],
        [(0, 0, 0.13), (0, 0, 0), (-0.61, 0, 0), (-0.57, 0, 0.16), (0, -0.116, 0), (0, 0.092, 0)],
        [7.6, 12.8, 4.3, 2.1, 2.1, 1.2],
        [(0, -0.02, -0.01), (-0.24, 0, 0.16), (-0.25, 0, 0.05),
         (0, -0.01, -0.01), (0, 0.01, -0.01), (0.01, 0.01, 0.03)],
        [(0.09, 0.08, 0.09), (0.07, 0.21, 0.21), (0.05, 0.18, 0.18),
         (0.06, 0.05, 0.06), (0.06, 0.05, 0.06), (0.04, 0.05, 0.05)],
    )  # fmt: skip
    return Arm(
        name="ur10like",
        body=body,
        limits=Limits(
            array(-3.14159, -2.9, -2.6, -3.14159, -3.14159, -3.14159),
            array(3.14159, -0.1, 2.6, 3.14159, 3.14159, 3.14159),
            array(2.1, 2.1, 3.1, 3.1, 3.1, 3.1),
            array(6.4, 5.6, 8.0, 14.4, 14.4, 16.0),
            array(330, 330, 150, 56, 56, 56),
        ),
        home=array(0.0, -1.35, 0.9, -0.6, 0.3, 0.0),
        gain=array(12.6, 12.9, 11.2, 9.4, 9.2, 9.5),
        gear=np.full(6, 101.0),
        rotor=array(2.6, 2.6, 1.2, 0.29, 0.29, 0.29),
        viscous=array(16.0, 15.0, 8.0, 2.6, 2.5, 2.2),
        coulomb=array(11.0, 13.0, 8.0, 2.2, 2.4, 2.1),
        encoder=np.full(6, 5e-6),
        current=np.full(6, 0.01),
        floor=array(0.54, 0.9, 0.49, 0.1, 0.1, 0.09),
        tool=Tool(4.0, array(0.02, -0.03, 0.07), array(0.16, 0.14, 0.12)),
        warm=True,
        balancer=NO_BALANCER,
    )


def iiwalike() -> Arm:
    """A lightweight arm of seven joints, driven in torque units."""
    body = chain(
        [0, -1, 1, 1, -1, -1, 1],
        [(0, 0, 0.36), (0, 0, 0), (0, -0.42, 0), (0, 0, 0), (0, 0.4, 0), (0, 0, 0), (0, -0.126, 0)],
        [4.1, 4.3, 2.9, 2.7, 1.8, 1.7, 0.5],
        [(0, -0.03, -0.07), (0, -0.06, 0.04), (0, 0.03, -0.11), (0, 0.07, 0.035), (0, -0.02, -0.14),
         (0, 0, 0.002), (0.01, 0.01, 0.03)],
        [(0.12, 0.11, 0.06), (0.12, 0.06, 0.11), (0.11, 0.1, 0.05), (0.1, 0.05, 0.09), (0.1, 0.09, 0.05),
         (0.06, 0.05, 0.05), (0.03, 0.03, 0.04)],
    )  # fmt: skip
    return Arm(
        name="iiwalike",
        body=body,
        limits=Limits(
            array(-2.9, -2.0, -2.9, -2.0, -2.9, -2.0, -3.0),
            array(2.9, 2.0, 2.9, 2.0, 2.9, 2.0, 3.0),
            array(1.7, 1.7, 1.7, 2.2, 2.4, 3.1, 3.1),
            array(6.4, 5.6, 8.0, 8.0, 11.2, 12.8, 14.4),
            array(176, 176, 110, 110, 110, 40, 40),
        ),
        home=array(0.0, 0.35, 0.0, -1.0, 0.0, 0.6, 0.0),
        gain=np.ones(7),
        gear=array(160, 160, 160, 160, 100, 160, 160),
        rotor=array(0.77, 0.76, 0.51, 0.52, 0.29, 0.153, 0.116),
        viscous=array(2.4, 2.9, 1.5, 1.5, 0.8, 0.48, 0.38),
        coulomb=array(1.8, 2.0, 1.0, 1.1, 0.55, 0.46, 0.36),
        encoder=np.full(7, 5e-6),
        current=np.full(7, 0.004),
        floor=array(0.14, 0.36, 0.12, 0.2, 0.05, 0.05, 0.022),
        tool=Tool(2.5, array(0.01, 0.015, 0.06), array(0.12, 0.12, 0.1)),
        warm=False,
        balancer=NO_BALANCER,
    )


ARMS = {"kr270": kr270, "ur10like": ur10like, "iiwalike": iiwalike}


NEVER = 1e9
"""A time, or a torque, that is not reached."""
WAVES = 4


class Prior(NamedTuple):
    """The nominal model; terms name what of it is in the model at all."""

    body: Body
    gain: np.ndarray
    rotor: np.ndarray
    viscous: np.ndarray
    coulomb: np.ndarray
    terms: dict[str, np.ndarray]
    balancer: np.ndarray
    inertial_tolerance: float
    gain_tolerance: float

    def without(self, term: str, joint: int) -> "Prior":
        """The same without a term on a joint."""
        terms = {name: np.array(there) for name, there in self.terms.items()}
        terms[term][joint] = False
        values = {} if term == "offset" else {term: np.where(terms[term], getattr(self, term), 0.0)}
        return self._replace(terms=terms, **values)


class Recorder(NamedTuple):
    """What happens to currents on their way to the log."""

    gain: np.ndarray  # True torque per current, (n,)
    delay: float  # By which currents are logged late [s]
    clip: np.ndarray  # Largest torque whose current is logged, (n,) [N m]
    mix: np.ndarray  # Share of one drive's current that shows in another's, (n, n) [-]
    sag: float  # Share by which all gains fall at full power of the whole arm [-]
    surge: np.ndarray  # Amplitude of a torque that pulses with the supply, its frequency, (n + 1,) [N m, Hz]
    lump: np.ndarray  # Dry friction that comes and goes at random, (n,) [N m]
    drag: np.ndarray  # Friction of brakes as a run starts, how long they take to open, (n, 2) [N m, s]
    colour: float  # Pole of the coloured noise at the recording's rate [-]
    floor: np.ndarray  # Noise, disturbances included, (n,) [N m]


@dataclass(frozen=True)
class Robot:
    """An arm that is recorded."""

    arm: Arm  # Its kind
    machine: Machine  # As it is
    recorder: Recorder  # How it is recorded
    prior: Prior  # The nominal model
    touched: str = ""  # Run in which there is a contact; elsewhere there is none
    peak: np.ndarray = field(default_factory=lambda: np.zeros(0))  # Torques of ordinary motion, (n,) [N m]

    def with_machine(self, **changes: object) -> "Robot":
        """Other values of the machine."""
        return replace(self, machine=self.machine._replace(**changes))

    def with_friction(self, **changes: object) -> "Robot":
        """Other values of the friction."""
        return self.with_machine(friction=self.machine.friction._replace(**changes))

    def with_recorder(self, **changes: object) -> "Robot":
        """Other values of the recorder."""
        return replace(self, recorder=self.recorder._replace(**changes))

    def without_term(self, term: str, joint: int) -> "Robot":
        """The same, but that its owner leaves a term out."""
        return replace(self, prior=self.prior.without(term, joint))


def honest(arm: Arm, rng: np.random.Generator) -> Robot:
    """A robot with which nothing is wrong: priors true within their tolerances, some terms not needed."""
    n = arm.joints
    tight = rng.random() < 0.5
    coulomb, viscous = arm.coulomb * rng.uniform(0.9, 1.1, n), arm.viscous * rng.uniform(0.9, 1.1, n)
    rotor = arm.rotor * rng.uniform(0.97, 1.03, n)
    terms = {name: np.full(n, True) for name in ("rotor_inertia", "viscous", "coulomb")}
    terms["offset"] = rng.random(n) < 0.6
    if rng.random() < 0.3:  # a joint without dry friction, whose owner knows
        free = rng.integers(min(3, n - 1), n)
        terms["coulomb"][free], coulomb[free] = False, 0.0
    offset = np.where(terms["offset"], rng.normal(0.0, 2.0, n) * arm.floor, 0.0)
    machine = _machine(arm, rotor, viscous, coulomb, offset, rng)
    gain_tolerance, tolerance = (0.01, 0.02) if tight else (0.02, 0.1)
    prior = Prior(
        _doubtful(arm.body, tolerance, rng),
        arm.gain * _about(gain_tolerance, n, rng),
        rotor * _about(tolerance, n, rng),
        viscous * _about(0.2, n, rng),
        coulomb * _about(0.2, n, rng),
        {name if name != "rotor_inertia" else "rotor": there for name, there in terms.items()},
        arm.balancer,
        tolerance,
        gain_tolerance,
    )
    return Robot(arm, machine, _recorder(arm, rng), prior)


def _about(tolerance: float, n: int, rng: np.random.Generator) -> np.ndarray:
    return 1.0 + rng.uniform(-tolerance, tolerance, n)


def _doubtful(body: Body, tolerance: float, rng: np.random.Generator) -> Body:
    """Nominal bodies: masses, centres and inertias within a tolerance, and physical."""
    n = len(body.mass)
    size = np.sqrt(np.trace(body.inertia, axis1=1, axis2=2) / body.mass)
    return body._replace(
        mass=body.mass * _about(tolerance, n, rng),
        com=body.com + tolerance * size[:, None] * rng.uniform(-0.5, 0.5, (n, 3)),
        inertia=body.inertia * _about(tolerance, n, rng)[:, None, None],
    )


def _machine(
    arm: Arm, rotor: np.ndarray, viscous: np.ndarray, coulomb: np.ndarray, offset: np.ndarray,
    rng: np.random.Generator,
) -> Machine:  # fmt: skip
    n = arm.joints
    bristle = rng.uniform(1.5e-5, 4e-5, n)
    # Half of the arms stick when they stop; grease lets the others creep.
    creep = rng.uniform(0.002, 0.005, n) if rng.random() < 0.5 else np.zeros(n)
    wheel = arm.gear[:, None] * np.array([1.0, 2.0, 3.0, 6.0])
    # Full speed for a day would end at 60 K above ambient; a run at a third of it warms by about 3 K.
    power = 0.3 * arm.limits.velocity * (arm.coulomb + 0.3 * arm.viscous * arm.limits.velocity)
    return Machine(
        body=arm.body,
        friction=plain_friction(coulomb, viscous, bristle, creep, rotor),
        rotor=np.diag(rotor),
        offset=offset,
        knee=np.full(n, NEVER),
        stiffness=np.zeros(n),
        loss=np.zeros(n),
        gap=np.zeros(n),
        cable=np.zeros((n, 3)),
        order=wheel,
        wave=np.zeros((n, WAVES)),
        phase=rng.uniform(0.0, 2.0 * np.pi, (n, WAVES)),
        balancer=arm.balancer,
        touch=np.array([NEVER, 1.0, 0.0, 0.0, 0.0]),
        hose=np.zeros(4),
        shake=np.array([0.0, 0.0, 0.0, 1.0]),
        miscount=np.zeros(n),
        ring=np.tile([0.0, 1.0, 0.0], (n, 1)),
        loose=np.zeros(3),
        spindle=np.zeros(3),
        count=arm.encoder / 8.0,  # drives interpolate what they report
        heat=3.0 / 24.0 / power,
        cooling=np.full(n, 500.0),
        push=_drive(arm, rotor),
    )


def _drive(arm: Arm, rotor: np.ndarray) -> np.ndarray:
    """Gains of a cascade, velocity loop of 15 Hz, for the inertia at home."""
    inertia = rotor + carried(arm.body, arm.home)
    fast = 2.0 * np.pi * 15.0
    return np.stack([np.full(arm.joints, 30.0), fast * inertia, 15.0 * fast * inertia, inertia], axis=1)


def carried(body: Body, pose: np.ndarray) -> np.ndarray:
    """Inertia of the links about each joint, (n,) [kg m^2]."""
    n = len(pose)
    turned, matrix = np.empty((n, 3, 3)), np.empty((n, n))
    turn(body.rotation, pose, turned)
    mass_matrix(body, turned, matrix)
    return np.diag(matrix).copy()


def _recorder(arm: Arm, rng: np.random.Generator) -> Recorder:
    n = arm.joints
    return Recorder(
        gain=np.array(arm.gain),
        delay=0.0,
        clip=np.full(n, NEVER),
        mix=np.zeros((n, n)),
        sag=0.0,
        surge=np.zeros(n + 1),
        lump=np.zeros(n),
        drag=np.tile([0.0, 1.0], (n, 1)),
        colour=rng.uniform(0.78, 0.88),
        floor=arm.floor * rng.uniform(0.9, 1.2),
    )


__all__ = ["NEVER", "NO_BALANCER", "WAVES", "Prior", "Recorder", "Robot", "carried", "honest"]
