"""`Estimate`, which every estimator returns, and `Compressed`, the rows from which it is computed.

QR compresses each joint's rows once, so that an iteration costs microseconds. The normal equations are never
formed, because they square the condition number.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from ...errors import NotExcited
from ..equations import Equations


@dataclass(frozen=True)
class Estimate:
    """Base parameters and drive gains with their uncertainty."""

    method: str  # name of the estimator
    values: np.ndarray  # base parameters, shape (b,)
    gain: np.ndarray  # torque per unit of current, shape (n,); nominal if the method does not estimate it
    # Covariance of values, then gains, shape (b + n, b + n). Nominal gains have their stated tolerance; gains
    # that are known or not stated have zero variance.
    covariance: np.ndarray
    noise: np.ndarray  # standard deviation of the residual of each joint, shape (n,) [N m]
    standard: np.ndarray | None = None  # standard parameters, shape (p,), if the method computes them
    nominal_gains: bool = False  # whether gains are nominal rather than estimated

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of the base parameters, shape (b,)."""
        return np.sqrt(np.diag(self.covariance)[: len(self.values)])

    @property
    def gain_std(self) -> np.ndarray:
        """Standard deviation of the drive gains, shape (n,)."""
        return np.sqrt(np.diag(self.covariance)[len(self.values) :])

    @property
    def gain_estimated(self) -> np.ndarray:
        """Whether each drive gain was estimated, shape (n,)."""
        return (self.gain_std > 0.0) & (not self.nominal_gains)


Estimator = Callable[[Equations], Estimate]


FEWEST = 10
"""Minimum number of rows for a noise estimate: ten give a standard deviation to within a quarter."""


@dataclass(frozen=True)
class Compressed:
    """Triangular factors R_j of [regressor, known, current], which preserve the norms of the rows."""

    factors: tuple[np.ndarray, ...]  # one array per joint, shape (rows, b + 2)
    counts: np.ndarray  # number of rows with nonzero weight of each joint, shape (n,)

    @classmethod
    def of(cls, equations: Equations) -> "Compressed":
        """Compress equations.

        Raises:
            NotExcited: A joint slides in fewer than `FEWEST` rows.
        """
        factors = [_factor(equations, joint) for joint in range(equations.current.shape[1])]
        return cls(tuple(factors), np.count_nonzero(equations.weight, axis=0))

    def updated(self, equations: Equations, joints: Iterable[int]) -> "Compressed":
        """Compressed equations after a change that affects only the rows of `joints`."""
        factors = list(self.factors)
        for joint in joints:
            factors[joint] = _factor(equations, joint)
        return replace(self, factors=tuple(factors))

    def regressor(self, joint: int) -> np.ndarray:
        """Compressed regressor of one joint."""
        return self.factors[joint][:, :-2]

    def known(self, joint: int) -> np.ndarray:
        """Compressed known torque of one joint."""
        return self.factors[joint][:, -2]

    def current(self, joint: int) -> np.ndarray:
        """Compressed current of one joint."""
        return self.factors[joint][:, -1]

    def torque(self, joint: int, gain: np.ndarray) -> np.ndarray:
        """Compressed measured torque of one joint minus the known torque."""
        return gain[joint] * self.current(joint) - self.known(joint)

    def residual_std(self, values: np.ndarray, gain: np.ndarray) -> np.ndarray:
        """Standard deviation of each joint's residual, shape (n,) [N m].

        Each joint loses b/n degrees of freedom. A joint without a motor always has zero torque, so values of
        zero solve its equations exactly, whether they are right or not. It gets the largest standard
        deviation of the other joints.
        """
        joints = range(len(self.factors))
        squares = [np.sum((self.torque(j, gain) - self.regressor(j) @ values) ** 2) for j in joints]
        freedom = np.maximum(self.counts - len(values) / len(self.factors), 1.0)
        deviations = np.sqrt(np.array(squares) / freedom)
        driven = np.array([np.any(self.torque(j, gain)) for j in joints])
        return np.where(driven, deviations, np.max(deviations, where=driven, initial=0.0))


def _factor(equations: Equations, joint: int) -> np.ndarray:
    """Triangular factor of one joint's weighted rows."""
    weight = equations.weight[:, joint]
    rows = np.column_stack(
        [equations.regressor[:, joint], equations.known[:, joint], equations.current[:, joint]]
    )
    rows = rows[weight > 0] * weight[weight > 0, None]
    if len(rows) < FEWEST:
        raise NotExcited(
            f"joint {joint + 1} slides in only {len(rows)} of {len(weight)} samples; "
            "record a motion in which it moves, or list it as held in robot.toml"
        )
    factor: np.ndarray = linalg.qr(rows, mode="r", overwrite_a=True, check_finite=False)[0]
    return factor[: factor.shape[1]]


def solve(rows: np.ndarray, right: np.ndarray, names: list[str]) -> np.ndarray:
    """Least-squares solution by QR with columns scaled to one.

    Raises:
        NotExcited: The motion does not distinguish some columns at all.
    """
    size = np.linalg.norm(rows, axis=0)
    if np.any(size == 0):
        unseen = [name for name, s in zip(names, size, strict=True) if s == 0]
        raise NotExcited(f"the motion does not reveal {', '.join(unseen)}; move the joints concerned")
    q, r = linalg.qr(rows / size, mode="economic", check_finite=False)
    diagonal = np.abs(np.diag(r))
    if np.min(diagonal) < 1e-12 * np.max(diagonal):  # rounding, not noise: the motion is degenerate
        unseen = [name for name, d in zip(names, diagonal, strict=True) if d < 1e-12 * np.max(diagonal)]
        raise NotExcited(
            f"the motion does not distinguish {', '.join(unseen)} from the others; excite more joints"
        )
    return linalg.solve_triangular(r, q.T @ right) / size
