"""Methods of a fit: predict torque, state a verdict, and write its file, its page, and models for simulators.

They depend on modules that import `Fit`, so they import those modules when they are called.
"""

from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from ..arm.motion import Motion
from ..errors import UnknownKey, WrongShape
from ..quantity import Quantity

if TYPE_CHECKING:
    from ..arm.servo_law import ServoLaw
    from ..feedforward.feedforward import Feedforward
    from ..model import Model
    from .fit import Fit


class FitMethods:
    """Methods of `Fit`."""

    def __getitem__(self, name: str) -> Quantity:
        """One base parameter by its name, with or without the R of regrouping.

        Example:
            >>> fit["Fv1"].value, fit["Fv1"].interval
            (3.02, (2.96, 3.08))

        Raises:
            KeyError: There is no such parameter, or it was dropped; the message lists the valid names.
        """
        fit = cast("Fit", self)
        value = fit.value(name)
        names = fit.names if name in fit.names else [regrouped.removesuffix("R") for regrouped in fit.names]
        place = names.index(name)
        return Quantity(value, float(fit.estimate.std[place]), fit.base.units[place])

    @property
    def gains(self) -> dict[str, Quantity]:
        """Drive gain of each joint by its name [N m/A], estimated or nominal, with its standard deviation."""
        fit = cast("Fit", self)
        estimate, joints = fit.estimate, fit.model.robot.joints
        rows = zip(joints, estimate.gain, estimate.gain_std, strict=True)
        return {joint: Quantity(float(value), float(std), "N m/A") for joint, value, std in rows}

    @property
    def verdict(self) -> str:
        """Sentences on how well the fit explains each joint, and what the runs do not determine."""
        from .verdict import verdict

        return "\n".join(verdict(cast("Fit", self)))

    def torque(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        payload: str = "",
        time: np.ndarray | None = None,
    ) -> np.ndarray:
        """Joint torque that the fit predicts for a motion, shape (t, n) [N m].

        Args:
            q: Position, shape (t, n) [rad], or (n,) for one sample.
            dq: Velocity, same shape [rad/s].
            ddq: Acceleration, same shape [rad/s^2].
            payload: Name of the body on the flange; empty for none.
            time: Time of the samples, shape (t,) [s]; only friction with memory needs it.

        Raises:
            WrongShape: The arrays have different shapes, or do not have one column per joint.
        """
        fit = cast("Fit", self)
        position, velocity, acceleration = parts = [np.atleast_2d(np.asarray(p, float)) for p in (q, dq, ddq)]
        shape = (len(parts[0]), fit.model.robot.dof)
        if any(part.shape != shape for part in parts):
            shapes = ", ".join(
                f"{name} {part.shape}" for name, part in zip(("q", "dq", "ddq"), parts, strict=True)
            )
            raise WrongShape(f"torque: shapes are {shapes}; expected {shape} (samples, joints) for each")
        time = np.arange(shape[0], dtype=float) if time is None else np.asarray(time, float)
        motion = fit.model.loaded(Motion.of(time, position, velocity, acceleration, payload=payload))
        regressor = fit.model.regressor(motion)[:, :, fit.base.kept]
        return np.asarray(regressor @ fit.estimate.values + fit.model.known_torque(motion))

    @property
    def identified(self) -> "Model":
        """The model with the physically consistent values nearest to the fit; see `Fit.moved`."""
        from .identified import identified

        return identified(cast("Fit", self))

    def save(self, path: Path | str) -> Path:
        """Write the fit as JSON for `ex.read_fit`; returns the path."""
        from .fit_file import write_fit

        write_fit(cast("Fit", self), path)
        return Path(path)

    def export(self, format: str, path: Path | str | None = None, payload: str = "") -> str:
        """Identified model as text for a simulator, also written to a file if a path is given.

        Args:
            format: Name in `FORMATS`, such as urdf, mjcf, isaaclab, mjlab, sdf, json or toml.
            path: File to write.
            payload: Name of a payload of the model that becomes part of the last link.

        Raises:
            UnknownKey: There is no such format; the message lists the valid ones.
        """
        from ..export import FORMATS, Portable

        if format not in FORMATS:
            raise UnknownKey(format, "export: format", tuple(FORMATS))
        text = FORMATS[format].text(Portable.of(self.identified, payload))
        if path is not None:
            Path(path).write_bytes(text.encode())
        return text

    def feedforward(
        self,
        payload: str = "",
        servo: "ServoLaw | None" = None,
        band: float | np.ndarray | None = None,
        share: float | None = None,
    ) -> "Feedforward":
        """Torque for gravity, friction and motion, as functions and as files for a controller.

        Args:
            payload: Name of the payload on the flange; empty for none.
            servo: Law of the position servos; by default that of the robot, if it has one.
            band: Speed below which friction is not compensated [rad/s], one value or one per joint; by
                default the speed below which a joint counted as standing in the runs.
            share: Share of the friction that is compensated, at least 0 and below 1 [-]; 0.7 by default.

        Example:
            >>> fit.feedforward().save("arm.hpp")

        Raises:
            FitError: There is no such payload, or a value is out of range.
        """
        from ..feedforward.feedforward import SHARE, Feedforward

        return Feedforward.of(cast("Fit", self), payload, servo, band, SHARE if share is None else share)

    def report(self, path: Path | str) -> Path:
        """Write the fit as one HTML page; returns the path."""
        from ..pages.fit_document import write_report

        write_report(cast("Fit", self), Path(path))
        return Path(path)
