"""Motion: what the joints did, the input of every effect."""

from dataclasses import dataclass, fields, replace

import numpy as np

from ..errors import WrongShape


@dataclass(frozen=True)
class Motion:
    """Joint motion on one time axis.

    Attributes:
        time: Shape (t,) [s].
        position: Shape (t, n) [rad], or [m] where the joint slides.
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        load: Torque that the gear transmits to its link, nominal, shape (t, n) [N m].
        temperature: Shape (t, n) [degC]; NaN where it was not measured.
        payload: Name of the body carried on the flange in this run; empty for none.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    load: np.ndarray
    temperature: np.ndarray
    payload: str = ""

    def __post_init__(self) -> None:
        shape = (*self.time.shape, *self.position.shape[1:])
        for name in ("position", "velocity", "acceleration", "load", "temperature"):
            found = getattr(self, name).shape
            if found != shape or len(shape) != 2:
                raise WrongShape(f"motion: {name} has shape {found}, expected {shape} (samples, joints)")

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
        """Motion with zero load and unknown temperature unless they are given."""
        load = np.zeros_like(position) if load is None else load
        temperature = np.full_like(position, np.nan) if temperature is None else temperature
        return cls(time, position, velocity, acceleration, load, temperature, payload)
