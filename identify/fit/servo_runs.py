"""Runs as the identification of servos needs them: low-passed signals on an even time axis."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ..arm.derivatives import differentiate
from ..arm.motion import Motion
from ..effects import RotorInertia
from ..model import Model
from ..preparation.cutoffs import position_cutoff
from ..preparation.even import Even
from ..preparation.filters import low_pass
from ..recordings.recording import Recording

LONGEST = 0.15
"""Longest delay of a command that is considered [s]: five cycles of a 30 Hz bus."""
REVERSAL = 0.02
"""Ratio of the velocity over which dry friction changes its sign to the rms velocity of the joint."""


@dataclass(frozen=True, eq=False)
class ServoRun:
    """Signals of one run; n joints."""

    rate: float  # sampling rate [Hz]
    cutoff: float  # cut-off of the low-pass that all signals but `raw_torque` have passed [Hz]
    position: np.ndarray  # positions, shape (t, n) [rad]
    velocity: np.ndarray  # velocities, shape (t, n) [rad/s]
    torque: np.ndarray  # torques, shape (t, n) [N m]
    raw_torque: np.ndarray  # torques before the low-pass, shape (t, n) [N m]
    command: CubicSpline  # commands as functions of the time since the first sample
    # Shapes of further torques of unknown size, shape (k, t, n); none if torque was measured.
    unknown: np.ndarray

    @classmethod
    def of(cls, recording: Recording, gain: np.ndarray) -> "ServoRun":
        """Signals of a recording with commands and effort; `gain` (n,) is the torque per current [N m/A]."""
        even = Even.of(recording, None)
        cutoff = position_cutoff(even.position, even.rate)
        position, command, torque = (
            low_pass(values, even.rate, cutoff)
            for values in (even.position, even.signal("command"), even.signal(even.measures))
        )
        scale = np.ones(len(gain)) if even.measures == "torque" else gain
        torque, raw_torque = scale * torque, scale * even.signal(even.measures)
        return cls(
            even.rate, cutoff, position, differentiate(position, even.rate)[0], torque, raw_torque,
            CubicSpline(even.time - even.time[0], command),
            np.empty((0, *position.shape)),
        )  # fmt: skip

    def with_model_torque(self, model: Model, rotor_inertia: bool) -> "ServoRun":
        """The run with the torque of the model's bodies, and unknown dry friction.

        Viscous friction is part of the damping that the fit finds.

        Args:
            model: The arm.
            rotor_inertia: Whether the rotor inertia is that of the model; otherwise it is unknown.
        """
        acceleration = differentiate(self.velocity, self.rate)[0]
        motion = Motion.of(self.time, self.position, self.velocity, acceleration)
        torque = np.sum(
            [
                effect.regressor(model.robot, motion) @ values
                for effect, values in model.shares(model.nominal_values)
                if effect.of_links or (rotor_inertia and isinstance(effect, RotorInertia))
            ],
            axis=0,
        )
        reversal = REVERSAL * np.sqrt(np.mean(self.velocity**2, axis=0)) + np.finfo(float).tiny
        dry = low_pass(np.tanh(self.velocity / reversal), self.rate, self.cutoff)
        unknown = [dry] if rotor_inertia else [dry, acceleration]
        return replace(self, torque=torque, raw_torque=torque, unknown=np.stack(unknown))

    def with_free_masses(self, model: Model) -> "ServoRun":
        """The run with links of unknown size, each heavier by a factor, and unknown dry friction."""
        acceleration = differentiate(self.velocity, self.rate)[0]
        motion = Motion.of(self.time, self.position, self.velocity, acceleration)
        links = []
        for effect, values in model.shares(model.nominal_values):
            if effect.of_links:
                torques = effect.regressor(model.robot, motion) * values
                links += list(np.moveaxis(torques.reshape(*torques.shape[:2], -1, 10).sum(axis=3), 2, 0))
        known = self.with_model_torque(model, rotor_inertia=True)
        rotor = known.torque - np.sum(links, axis=0)
        unknown = np.concatenate([known.unknown, rotor[None], np.array(links)])
        none = np.zeros_like(self.torque)
        return replace(self, torque=none, raw_torque=none, unknown=unknown)

    @property
    def inside(self) -> slice:
        """Samples away from the transients of the filters, thinned to the band of the low-pass."""
        edge = int(self.rate * (LONGEST + 2.0 / self.cutoff))
        return slice(edge, len(self.position) - edge, max(1, int(self.rate / (4.0 * self.cutoff))))

    @property
    def time(self) -> np.ndarray:
        """Time since the first sample, shape (t,) [s]."""
        return np.arange(len(self.position)) / self.rate
