"""A drawn arm with a drawn payload: recorded, weighed in three ways, and compared with the truth.

The arm differs from its description in every link, gain and friction by draws of their tolerances. Part of
the errors of links and of gains is common, as exidyn assumes; those of the links may be a multiple of it.
Its gears have friction under load that no model here has. The runs of the fit are of another day, on which
friction differs by 15 %, and drive gains, which depend on temperature, by 1.5 %. Half of the current noise
lasts for 50 ms, and currents are quantized.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy import signal

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import EFFECTS, Payload, Prior, RigidBody, known_parameters
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.payload.body import Body
from exidyn.identification.payload.known import ALIKE
from exidyn.identification.payload.payload_estimate import DESCRIPTION, DIFFERENCE, FIT, PayloadEstimate
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

from ..real.data import FOLDER


@dataclass(frozen=True)
class Arm:
    """An arm and the payloads that it carries."""

    name: str  # Name in the tables
    source: str  # Built-in name, or path in the folder of data
    masses: tuple[float, ...]  # Payloads [kg]
    size: float  # Distance of a payload's points from the flange [m]
    torque: tuple[float, ...] = ()  # Rated torque, scales friction [N m]; empty if the file states it
    gain: float = 0.0  # Drive gain [N m/A]; 0 if torque is measured, or if the file states gains
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


WAYS = (FIT, DIFFERENCE, DESCRIPTION)
"""What is known of the arm."""
RATE, EMPTY, LOADED = 200.0, 30.0, 16.0
"""Samples a second [Hz], and duration of the runs of the arm and of the run with the payload [s]."""
NOISE, MEMORY, BITS = 0.01, 0.05, 11
"""Each half of the current noise over the rms current, how long one half lasts [s], bits of a current."""
FRICTION, WARMER = 0.15, 0.015
"""Changes of friction and of drive gains from day to day."""
UNDER_LOAD = 0.03
"""Deviation of friction over transmitted torque."""
REFERENCE = 0.5
"""Mass of the weighed payload, for the drive gains, over that of the one to identify; at least."""


class Case(NamedTuple):
    """One payload on one drawn arm."""

    arm: Arm
    mass: float
    seed: int
    links: float  # errors of the links over their tolerance

    @property
    def name(self) -> str:
        """Name among results that are kept."""
        return f"{self.arm.name}, {self.mass:g} kg, {self.seed}, {self.links:g}"


class Drawn(NamedTuple):
    """A drawn arm: its parameters, gains and friction under load."""

    nominal: Model
    values: np.ndarray
    gain: np.ndarray
    under_load: np.ndarray


def drawn_body(random: np.random.Generator, mass: float, size: float) -> Body:
    """A body of eight points of random mass and place, each with some extent."""
    points = size * (random.normal(size=(8, 3)) * [0.6, 0.6, 0.8] + random.normal([0.2, 0.1, 1.0], 0.3))
    weights = mass * random.dirichlet(np.ones(8))
    center = weights @ points / mass
    arms = points - center
    inertia = sum(w * (a @ a * np.eye(3) - np.outer(a, a)) for w, a in zip(weights, arms, strict=True))
    return Body(mass, center, inertia + mass * (0.2 * size) ** 2 * np.eye(3))


def drawn_arm(random: np.random.Generator, nominal: Model, links: float) -> Drawn:
    """The arm with errors of its tolerances, those of the links times `links`."""
    std = np.array([prior.std for prior in nominal.priors])
    values, robot, n = nominal.nominal_values, nominal.robot, nominal.robot.dof
    errors = np.where(np.isfinite(std), std, 0.0) * random.normal(size=len(std))
    for effect, columns in zip(nominal.effects, nominal.columns, strict=True):
        if effect.of_links:
            common = robot.inertial_tolerance * random.normal() * values[columns]
            errors[columns] = links * (np.sqrt(1.0 - ALIKE) * errors[columns] + np.sqrt(ALIKE) * common)
    gain = robot.drive_gain.copy()
    if np.any(gain != 1.0):
        gain *= 1.0 + robot.drive_gain_tolerance * alike(random, n)
    values = values + errors
    return Drawn(nominal, values, gain, np.abs(UNDER_LOAD * random.normal(size=n)))


def alike(random: np.random.Generator, n: int) -> np.ndarray:
    """Normal numbers, shape (n,), that share part of their variance."""
    return np.sqrt(ALIKE) * random.normal() + np.sqrt(1.0 - ALIKE) * random.normal(size=n)


def on_another_day(drawn: Drawn, random: np.random.Generator) -> Drawn:
    """The arm with other friction, and with drive gains of another temperature if it has any."""
    values, gain = drawn.values.copy(), drawn.gain
    for effect, columns in zip(drawn.nominal.effects, drawn.nominal.columns, strict=True):
        if effect.greased:
            values[columns] *= 1.0 + FRICTION * random.normal(size=columns.stop - columns.start)
    if np.any(gain != 1.0):
        gain = gain * (1.0 + WARMER * alike(random, len(gain)))
    return drawn._replace(values=values, gain=gain)


def recorded(
    arm: Arm,
    drawn: Drawn,
    body: Body | None,
    seconds: float,
    seed: int,
    random: np.random.Generator,
) -> Recording:
    """A run of the drawn arm on a motion of its own."""
    plant, payload = drawn.nominal, None
    if body is not None:
        known = tuple(zip(INERTIAL, map(float, body.parameters), strict=True))
        plant, payload = plant + Payload("L", known), KnownPayload("L", known)
    gears = EFFECTS["load_dependent_friction"]()
    plant = plant + gears
    plant = plant.at(np.concatenate([drawn.values, drawn.under_load]))
    path = random_fourier(drawn.nominal.robot.limits, seconds, seed=seed)
    motion = path.at(np.arange(round(seconds * RATE)) / RATE)
    name = f"{'empty' if body is None else 'loaded'} {seed}"
    run = simulate(
        plant, plant.nominal_values, drawn.gain, motion, drawn.nominal, Sensors(0.0), payload, name, seed
    )
    return noisy(arm, replace(run, payload=None), random)


def noisy(arm: Arm, run: Recording, random: np.random.Generator) -> Recording:
    """The run with noise and quantization; its currents are torques if the arm has sensors for them."""
    current = run.signals["current"]
    rms = np.sqrt(np.mean(current.values**2, axis=0))
    white, lasting = random.normal(size=(2, *current.values.shape))
    share = np.exp(-1.0 / (RATE * MEMORY))
    lasting = signal.lfilter([np.sqrt(1.0 - share**2)], [1.0, -share], lasting, axis=0)
    step = np.max(np.abs(current.values), axis=0) / 2.0**BITS
    values = np.round((current.values + NOISE * rms * (white + lasting)) / step) * step
    others = {name: other for name, other in run.signals.items() if name != "current"}
    measured = "torque" if arm.measures_torque else "current"
    return replace(run, signals={**others, measured: Signal(current.time, values)})


def estimates(case: Case) -> tuple[Body, dict[str, PayloadEstimate]]:
    """The payload, and what each way says of it; a fit does not depend on the links' tolerance."""
    ways = WAYS if case.links == 1.0 else WAYS[1:]
    random = np.random.default_rng([case.seed, round(1000 * case.mass)])
    arm, nominal = case.arm, case.arm.model()
    drawn, body = drawn_arm(random, nominal, case.links), drawn_body(random, case.mass, case.arm.size)
    before, seed = on_another_day(drawn, random), 4 * case.seed
    loaded = recorded(arm, drawn, body, LOADED, seed, random)
    found: dict[str, PayloadEstimate] = {}
    if FIT in ways:
        fitted = [recorded(arm, before, None, EMPTY, seed + 1, random)]
        if not arm.measures_torque:  # the gains come from a payload of which the mass is known
            mass = max(arm.masses) * REFERENCE
            weight = drawn_body(random, mass, arm.size)
            known = KnownPayload("W", known_parameters(mass))
            run = recorded(arm, before, weight, EMPTY, seed + 2, random)
            fitted.append(replace(run, payload=known))
        found[FIT] = weigh([loaded], fit=identify(fitted, as_recorded=True), as_recorded=True)
    empty = recorded(arm, drawn, None, EMPTY, seed + 3, random)
    found[DIFFERENCE] = weigh([loaded], empty=[empty], as_recorded=True)
    found[DESCRIPTION] = weigh([loaded], model=nominal, as_recorded=True)
    return body, found


def scored(body: Body, result: PayloadEstimate) -> dict[str, Any]:
    """Error of the mass, whether intervals hold the truth, and their widths."""
    inertia = body.inertia[np.triu_indices(3)]
    return {
        "error_percent": 100.0 * (result.mass.value / body.mass - 1.0),
        "half_percent": 100.0 * result.mass.half / body.mass,
        "mass": [bool(result.mass.holds(body.mass))],
        "center": [bool(i.holds(value)) for i, value in zip(result.center, body.center, strict=True)],
        "inertia": [bool(i.holds(value)) for i, value in zip(result.inertia, inertia, strict=True)],
        "center_error_mm": 1e3 * float(np.linalg.norm(result.body.center - body.center)),
        "check": result.check.passed,
        "seconds": result.seconds,
    }


def of_case(case: Case) -> dict[str, Any]:
    """Scores of one case by what is known of the arm."""
    body, found = estimates(case)
    return {way: scored(body, result) for way, result in found.items()}
