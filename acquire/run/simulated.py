"""Runs on a simulated arm: recordings of planned motions, and the rehearsal before the real arm moves."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial

import numpy as np

from exidyn import __version__
from exidyn.identification.errors import RobotError
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import SIMULATED, KnownPayload, Recording
from exidyn.identification.simulation.plant import Plant, Sensors, Transmission
from exidyn.identification.simulation.plant.plant import Watched
from exidyn.identification.simulation.plant.typical import typical_parts
from exidyn.identification.simulation.simulate import follow
from exidyn.trajectories.errors import TrajectoryError
from exidyn.trajectories.families.sequence import Slowed
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.plans.plan import Plan, robot_differences
from exidyn.trajectories.plans.plan_file import plan_text
from exidyn.trajectories.trajectory import Trajectory

from .arms import make_driver, simulated_arm
from .before import NO_MARGIN
from .errors import NotAllowed, explained_if_slow
from .frames import END, text_frame
from .perform import Job, Outcome, perform
from .pipe import Nobody, Sink
from .player import Player


def simulated(
    arm: Model,
    plan: Plan,
    loaded: Model,
    payload: KnownPayload | None,
    gears: Transmission | None = None,
    *,
    speed: float = 1.0,
    tick: float = 0.002,
    seed: int = 0,
    exact: bool = False,
    name: str = "simulated",
    watched: Watched = iter,
) -> Recording:
    """Simulate a run of a plan on an arm with typical drives and sensors, tuned to the true arm.

    `arm` and `payload` are those of the recording, `loaded` is the true arm with its payload. `gears` are
    between motors and links, in addition to the arm's own; rigid by default. The sampling period `tick` is
    in s.

    Raises:
        RobotError: If the arm has no such payload.
        TrajectoryError: If the plan is for other joints.
    """
    if plan.joints != arm.robot.joints:
        raise TrajectoryError(robot_differences(plan, arm.robot)[0])
    carried = payload.name if payload else ""
    bodies = {body for effect in loaded.effects for body in [getattr(effect, "name", "")] if body}
    if carried and carried not in bodies:
        raise RobotError(
            f"{arm.robot.name}: no payload '{carried}'. Payloads of the model: "
            f"{', '.join(sorted(bodies)) or 'none'}"
        )
    transmission = Transmission.of(loaded)
    if gears is not None:
        transmission = transmission.softened(gears.stiffness, gears.damping, gears.backlash)
    position, velocity = commands(plan.trajectory, speed, arm, tick)
    control, sensors, thermal = typical_parts(loaded)
    sensors = Sensors.exact(loaded.robot.dof) if exact else sensors
    with explained_if_slow():
        plant = Plant(
            loaded, loaded.nominal_values, loaded.robot.drive_gain, position[0], control, sensors,
            transmission, thermal, carried, seed=seed,
        )  # fmt: skip
    signals = follow(plant, position, velocity, tick, watched)
    if not np.any(np.isfinite(transmission.stiffness)):
        del signals["link_position"]  # a link encoder would measure the same
    source = f"simulated, seed {seed}"
    settings = {"source": source, SIMULATED: arm.robot.name, "speed": f"{speed:g}", "exidyn": __version__}
    return Recording(name, arm, signals, payload, trajectory=plan_text(plan), settings=settings)


def commands(motion: Trajectory, speed: float, arm: Model, tick: float) -> tuple[np.ndarray, np.ndarray]:
    """Commanded position [rad] and velocity [rad/s], each (t, n), from rest through the motion to rest."""
    played = motion if speed == 1.0 else Slowed(motion, speed)
    player = Player(played, usable(arm.robot, NO_MARGIN).limits, tick)
    player.begin(player.approach(played.state_at(0.0).position))
    rows = []
    while not player.finished and (command := player.next()) is not None:
        rows.append((command.position, command.velocity))
    position, velocity = np.moveaxis(np.array(rows), 1, 0)
    return position, velocity


def rehearse(job: Job, model: Model, cycle: float, payload: str = "", shown: Sequence[Sink] = ()) -> Outcome:
    """Perform a job with the mock driver and the nominal arm, which stands at the start of the motion.

    The model has its payload; the cycle [s] is that of the real controller. Sinks are closed at the end.

    Raises:
        NotAllowed: If the simulated arm had to be stopped.
    """
    start = job.motion.state_at(0.0).position
    settings = {"cycle": cycle, "clock": "stepped"}
    plant = partial(simulated_arm, model, start, payload=payload)
    driver = make_driver("mock", settings, model.robot, plant)
    watch = replace(job.watch, temperature=float("inf"))  # the temperature of the real arm is unknown
    with ExitStack() as stack:
        sinks = [stack.enter_context(closing(sink)) for sink in (Nobody(), *shown)]
        outcome = perform(driver, replace(job, settle=cycle, watch=watch), sinks)
        for sink in sinks:
            sink.put(text_frame(END, {}))
    if outcome.stop is not None:
        raise NotAllowed(
            f"the run was stopped in a rehearsal on the simulated arm: {outcome.stop.text}. Check the "
            "limits and drive gains of the robot file, or play it slower (exidyn record --speed)"
        )
    return outcome
