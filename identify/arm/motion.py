"""`Motion`: the motion of the joints, the input of every effect."""

from dataclasses import dataclass, fields, replace

import numpy as np

from ..errors import WrongShape


@dataclass(frozen=True)
class Motion:
    """Joint motion on one time axis."""

    time: np.ndarray  # time, shape (t,) [s]
    position: np.ndarray  # joint position, shape (t, n) [rad], or [m] for prismatic joints
    velocity: np.ndarray  # joint velocity, shape (t, n) [rad/s]
    acceleration: np.ndarray  # joint acceleration, shape (t, n) [rad/s^2]
    load: np.ndarray  # nominal torque that the gear transmits to the link, shape (t, n) [N m]
    temperature: np.ndarray  # temperature, shape (t, n) [degC]; NaN if not measured
    payload: str = ""  # name of the payload in this run; empty for none

    def __post_init__(self) -> None:
        shape = (*self.time.shape, *self.position.shape[1:])
        for name in ("position", "velocity", "acceleration", "load", "temperature"):
            actual = getattr(self, name).shape
            if actual != shape or len(shape) != 2:
                raise WrongShape(f"motion: {name} has shape {actual}, expected {shape} (samples, joints)")

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: slice) -> "Motion":
        arrays = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "payload"}
        return replace(self, **arrays)

    @classmethod
    def of(
        cls,
        time: np.ndarray,
        position: np.ndarray,
        velocity: np.ndarray,
        acceleration: np.ndarray,
        load: np.ndarray | None = None,
        temperature: np.ndarray | None = None,
        payload: str = "",
    ) -> "Motion":
        """Create a motion; load defaults to zero, and temperature to unknown."""
        load = np.zeros_like(position) if load is None else load
        temperature = np.full_like(position, np.nan) if temperature is None else temperature
        return cls(time, position, velocity, acceleration, load, temperature, payload)
