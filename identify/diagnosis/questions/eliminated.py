"""Eliminated: columns of candidates without the part that the unknowns of a prediction explain."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..blocks.prediction import Prediction
from .candidate import Thinned
from .candidate_fit import Fitted, solved, with_diagonal


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Columns of i candidates, p each, whitened, after a fit of the prediction's unknowns to all blocks."""

    prediction: Prediction  # prediction without the candidates
    unexplained: np.ndarray  # part of the columns that the unknowns do not explain, shape (i, p, k, n, l)
    products: np.ndarray  # products with the unknowns over fitted blocks, shape (i, p, b)
    whitened: np.ndarray  # these products, whitened, shape (i, p, b)
    matrix: np.ndarray  # normal matrices of the coefficients, shape (i, p, p)
    right: np.ndarray  # right-hand sides, shape (i, p)

    @classmethod
    def of(cls, prediction: Prediction, alike: Sequence[Thinned]) -> "Eliminated":
        """Eliminate the unknowns of a prediction from candidates with the same number of columns."""
        shape = len(alike), alike[0].values.shape[2]
        products, matrix = np.zeros((*shape, len(prediction.rows.std))), np.zeros((*shape, shape[1]))
        right, by_joint = np.zeros(shape), _by_joint(prediction, alike)
        fitted = prediction.blocks.fitted
        for joint, (members, columns) in by_joint.items():
            acting = prediction.sums.acting[joint]
            rows = columns[:, :, fitted].reshape(len(members), shape[1], -1)
            unknowns = prediction.whitened[joint][fitted].reshape(-1, len(acting))
            products[members[:, None, None], np.arange(shape[1])[:, None], acting] += rows @ unknowns
            matrix[members] += gram(rows)
            right[members] += rows @ prediction.whitened_torque[fitted, joint].ravel()
        whitened = products @ prediction.root.T
        unexplained = _torque(prediction, -(whitened @ prediction.root))
        for joint, (members, columns) in by_joint.items():
            unexplained[members, :, :, joint] += columns
        return cls(
            prediction,
            unexplained,
            products,
            whitened,
            matrix - gram(whitened),
            right - products @ prediction.values,
        )

    def decrease(self, coefficients: np.ndarray) -> np.ndarray:
        """Decrease of the unknowns, shape (i, b), with coefficients (i, p)."""
        # Faster than matrix products for few rows.
        return np.asarray(np.einsum("ip,ipb->ib", coefficients, self.whitened)) @ self.prediction.root

    @cached_property
    def left_out(self) -> np.ndarray:
        """The unexplained part in each block if this block is left out, shape (i, p, k, n, l)."""
        flat = self.unexplained.reshape(-1, *self.unexplained.shape[2:])
        return self.prediction.leaving_out.applied(flat).reshape(self.unexplained.shape)

    def predicted(self, fits: Fitted) -> np.ndarray:
        """Change of the whitened prediction of each block by the others with each candidate, (i, k, n, l)."""
        residual, fitted = self.prediction.whitened_errors, self.prediction.blocks.fitted[:, None]
        own, left_out = (x.reshape(*x.shape[:3], -1) for x in (self.unexplained, self.left_out))
        products = np.einsum("ipkr,iqkr->ikpq", own, left_out)
        along = np.einsum("ipkr,kr->ikp", own, residual.reshape(len(residual), -1))
        # A fit without a block has less information; without a held-out block, it is the same.
        matrix = with_diagonal(self.matrix, fits.precision)[:, None] - products * fitted[..., None]
        right = (along - np.einsum("ikpq,iq->ikp", products, fits.values)) * fitted
        decrease = solved(matrix, right, np.zeros(right.shape), fits.free[:, None])
        change = np.einsum("ikp,ipkr->ikr", fits.values[:, None] - decrease, left_out)
        return change.reshape(len(change), *residual.shape)


def _by_joint(prediction: Prediction, alike: Sequence[Thinned]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Joint -> numbers (m,) of the candidates that act on it, and their whitened columns (m, p, k, l)."""
    places: dict[int, list[tuple[int, int]]] = {}
    for number, columns in enumerate(alike):
        for place, joint in enumerate(columns.joints.tolist()):
            places.setdefault(joint, []).append((number, place))
    by_joint = {}
    for joint, acting in places.items():
        rows = np.stack([alike[number].values[:, place].T for number, place in acting])
        rows *= prediction.rows.weight[:, joint]
        columns = prediction.sums.arranged(rows) * prediction.scale[:, joint, None]
        by_joint[joint] = np.array([number for number, _ in acting]), columns
    return by_joint


def _torque(prediction: Prediction, unknowns: np.ndarray) -> np.ndarray:
    """Whitened torque of unknowns (..., b) in each block, shape (..., k, n, l)."""
    torque = np.empty((*unknowns.shape[:-1], *prediction.whitened_errors.shape))
    for joint, (columns, acting) in enumerate(zip(prediction.whitened, prediction.sums.acting, strict=True)):
        rows = unknowns[..., acting] @ columns.reshape(-1, len(acting)).T
        torque[..., joint, :] = rows.reshape(*unknowns.shape[:-1], *columns.shape[:2])
    return torque


def gram(rows: np.ndarray) -> np.ndarray:
    """Products of rows (..., p, b) with each other, shape (..., p, p)."""
    if rows.shape[-2] == 1:  # thousands of matrices of one element
        return np.einsum("...pb,...pb->...p", rows, rows)[..., None]
    return np.asarray(rows @ np.swapaxes(rows, -1, -2))
