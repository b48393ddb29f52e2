"""Effects that no description has, in right logs of a simulated arm: does the check take one for a mistake?

Each effect is about as large as what the joint's torque varies by: larger than most real arms show.
"""

from collections.abc import Iterator

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import body_regressor
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal

from .arms import SIX, fourier, model_of, torques
from .engine import claims_about
from .statements import CERTAIN

SECONDS, RATE = 20.0, 100.0
TOOLS = (1.0, 3.0, 8.0)
"""Masses on the flange that the description lacks [kg]."""


def hidden_effects(quick: bool) -> dict[str, object]:
    """Right logs with a hidden effect, and how many a mistake is suspected of, and how many surely."""
    motion, model = fourier(SIX.middle, np.arange(0.0, SECONDS, 1 / RATE), 4, 0.3), model_of(SIX)
    suspected, certain, count = [], [], 0
    for name, torque in list(_effects(motion, model))[:: 14 if quick else 1]:
        signals = {"position": Signal(motion.time, motion.position), "torque": Signal(motion.time, torque)}
        count += 1
        for claim in claims_about([Recording(name, model, signals)], model):
            suspected.append(f"{name}: {claim.text}")
            certain += [name] * (claim.probability > CERTAIN)
    print("\n".join(suspected))
    return {"hidden_effects": count, "hidden_suspected": len(suspected), "hidden_certain": len(certain)}


def _effects(motion: Motion, model: Model) -> Iterator[tuple[str, np.ndarray]]:
    rng, torque = np.random.default_rng(4), torques(SIX, motion)
    position, direction = motion.position, np.tanh(motion.velocity / 0.02)
    size = torque.std(axis=0)
    for j in range(torque.shape[1]):
        other = (j + 1) % torque.shape[1]
        terms = {
            "hose": 1.5 * np.sin(2.0 * position[:, j] + 1.0),
            "load friction": 0.4 * np.abs(torque[:, j]) / size[j] * direction[:, j],
            "noise": rng.normal(size=len(torque)),
            "ripple": 0.5 * np.sin(40.0 * position[:, j]),
            "neighbor's friction": 0.5 * direction[:, other],
            "asymmetry": 0.5 * (direction[:, j] > 0),
        }
        for name, term in terms.items():
            yield f"{name} of joint {j + 1}", torque + size[j] * np.outer(term, np.arange(6) == j)
    for delay in (0.01, 0.03, 0.06):
        late = [np.interp(motion.time - delay, motion.time, column) for column in torque.T]
        yield f"torque {1e3 * delay:.0f} ms late", np.column_stack(late)
    columns = body_regressor(model.robot.kinematics, motion, model.robot.flange)
    for mass in TOOLS:
        yield (
            f"tool of {mass:g} kg",
            torque + columns @ (mass * np.array([0, 0, 0, 0, 0, 0, 0.02, 0, 0.08, 1])),
        )
