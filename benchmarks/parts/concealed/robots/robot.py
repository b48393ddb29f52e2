"""One robot of a concealed case: the arm as it is, its nominal model, and how it is recorded."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..plant.body import Body, mass_matrix, turn
from ..plant.friction import plain_friction
from ..plant.machine import Machine
from .arms import NO_BALANCER, Arm

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
    # Largest torques of ordinary motion, (n,) [N m]
    peak: np.ndarray = field(default_factory=lambda: np.zeros(0))

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
