"""Filtering: which filters are asked for, and which of them a recording can have."""

from dataclasses import dataclass

import numpy as np

from ..errors import RecordingError

FROM_DATA = "leave it out to have it chosen from the data"


@dataclass(frozen=True)
class Filtering:
    """How to filter; what is None is chosen from the data.

    Attributes:
        rate: Sample rate of the even time axis [Hz]; the recording's median rate by default.
        position_cutoff: Low-pass of positions before differentiation [Hz].
        torque_cutoff: Parallel decimation of torque and regressor [Hz].
        standstill: Speed below which a joint sticks rather than slides [rad/s], one for all joints.

    Raises:
        RecordingError: One that is not above zero.
    """

    rate: float | None = None
    position_cutoff: float | None = None
    torque_cutoff: float | None = None
    standstill: float | None = None

    def __post_init__(self) -> None:
        for option, value in (*self._cutoffs, ("--standstill", self.standstill)):
            unit = "rad/s" if option == "--standstill" else "Hz"
            if value is not None and not value > 0.0:
                raise RecordingError(f"{option} is {value:g} {unit}; it must be above 0; {FROM_DATA}")

    @property
    def _cutoffs(self) -> tuple[tuple[str, float | None], ...]:
        return ("--position-cutoff", self.position_cutoff), ("--torque-cutoff", self.torque_cutoff)

    def check_cutoffs(self, rate: float, run: str) -> None:
        """Refuse a cut-off that no filter of a run at this rate [Hz] can have.

        Raises:
            RecordingError: Not below half the sample rate.
        """
        for option, cutoff in self._cutoffs:
            if cutoff is not None and not cutoff < 0.5 * rate:
                raise RecordingError(
                    f"{option} is {cutoff:g} Hz; it must lie below {0.5 * rate:g} Hz, half the sample "
                    f"rate of {run}; {FROM_DATA}"
                )

    def check_standstill(self, velocity: np.ndarray, run: str) -> None:
        """Refuse a standstill that leaves nothing of velocities, shape (t, n) [rad/s].

        Raises:
            RecordingError: Above the speed of every joint.
        """
        fastest = float(np.max(np.abs(velocity)))
        if self.standstill is not None and not self.standstill <= fastest:
            raise RecordingError(
                f"--standstill is {self.standstill:g} rad/s; it must lie below {fastest:.3g} rad/s, the "
                f"highest speed of any joint in {run}; {FROM_DATA}"
            )
