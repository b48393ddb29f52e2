"""What a diagnosis names is in found.toml, and the same recordings show nothing more beside it."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis import diagnose
from exidyn.identification.diagnosis.improved.improved import found_model, left_out
from exidyn.identification.measurements import (
    Backlash,
    CurrentClipping,
    DriveGainSaturation,
    JointElasticity,
    Measurement,
    TimeDelay,
)
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import ROLES, TRUE, nominal_model

pytestmark = pytest.mark.slow

CASES = {
    "time_delay": TimeDelay(0.013),
    "joint_elasticity": JointElasticity("elbow", 600.0, 1.0),
    "backlash": Backlash("elbow", 0.01, 0.4),
    "drive_gain_saturation": DriveGainSaturation("shoulder", 0.8, 20.0, 10.0),
    "current_clipping": CurrentClipping(0.9, ("shoulder",)),
}


def recording(measurement: Measurement, role: str, seed: int) -> Recording:
    """A fast motion whose motors move exactly; the elbow's load passes through zero."""
    path = random_fourier(two_joints.arm().limits, 16.0, period=2.0, seed=seed)
    motion = path.at(np.arange(0.0, 16.0, 0.004))
    motion = replace(motion, position=motion.position + np.array([0.0, 1.5]))
    plant = replace(two_joints.model(), measurements=(measurement,))
    values = np.array([TRUE.get(n, v) for n, v in zip(plant.names, plant.nominal_values, strict=True)])
    made = simulate(plant, values, two_joints.GAIN, motion, nominal_model(), name=f"{role}{seed}", seed=seed)
    return replace(made, settings={**made.settings, "role": role})


@pytest.mark.parametrize(
    "effect", ["time_delay", *(pytest.param(name, marks=pytest.mark.long) for name in [*CASES][1:])]
)
def test_what_is_named_is_held_and_not_named_again(effect):
    runs = [(role, recording(CASES[effect], role, seed)) for seed, role in enumerate(ROLES)]
    first = diagnose(nominal_model(), runs, "first", as_recorded=True)
    assert [finding.effect for finding in first.findings] == [effect]
    assert left_out(first) == ()
    model = parse_model(model_text(found_model(first)))
    assert isinstance(model.measurements[0], type(CASES[effect]))
    second = diagnose(model, runs, "second", as_recorded=True)
    assert second.findings == ()
    assert np.all(second.torque_rms_before < 1.3 * first.torque_rms_after)
