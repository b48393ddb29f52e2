"""Recordings of the arm in two_joints.py as files, for what takes files."""

from dataclasses import replace
from functools import cache

import numpy as np

from exidyn.identification.effects import Payload
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.simulation.simulate import simulate

from . import two_joints

WRONG = 1.1
"""Nominal over true drive gain."""
PLANT = two_joints.model(Payload("L"))
NOMINAL = two_joints.model(gain=WRONG * two_joints.GAIN)


@cache
def run(
    name: str,
    motion_seed: int = 0,
    noise_seed: int = 1,
    payload: KnownPayload | None = None,
    reach: tuple[float, float] = (1.0, 1.0),
) -> Recording:
    """A run of 20 s, in which each joint uses a share `reach` of its motion."""
    motion = two_joints.trajectory(20.0, motion_seed).at(np.arange(0.0, 20.0, 0.004))
    moved = {one: reach * getattr(motion, one) for one in ("position", "velocity", "acceleration")}
    motion = replace(motion, **moved)
    values = dict(zip(PLANT.names, two_joints.true_values(PLANT, 3.0), strict=True)) | {"ML": 3.0}
    return simulate(
        PLANT,
        np.array([values[n] for n in PLANT.names]),
        two_joints.GAIN,
        motion,
        NOMINAL,
        payload=payload,
        name=name,
        seed=noise_seed,
    )


def loaded(payload: KnownPayload | None = None) -> Recording:
    """A run with 3 kg, of which the file contains `payload`."""
    return replace(run("loaded", 1, 2, KnownPayload("L")), payload=payload)


def of_another_arm(recording: Recording) -> Recording:
    """The recording, claimed to be of an arm with a longer forearm."""
    robot = recording.robot
    kinematics = robot.kinematics.copy()
    kinematics.jointPlacements[2].translation = np.array([0.5, 0.0, 0.0])
    return replace(recording, model=replace(recording.model, robot=replace(robot, kinematics=kinematics)))


def write(folder, *recordings: Recording) -> list[str]:
    paths = []
    for recording in recordings:
        path = folder / f"{recording.name}.mcap"
        write_recording(recording, path)
        paths.append(str(path))
    return paths
