"""Eliminated: columns of candidates without the part that the unknowns of a prediction explain."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..blocks.prediction import Prediction
from .candidate import Thinned
from .candidate_fit import Fitted, solved, with_diagonal


class ActingOn(NamedTuple):
    """Whitened columns of the m candidates that act on one joint, p each, and their products in each block."""

    members: np.ndarray  # numbers of the candidates, shape (m,)
    columns: np.ndarray  # columns, shape (k, l, m, p)
    squares: np.ndarray  # products of the columns, shape (k, m, p, p)
    products: np.ndarray  # products with the unknowns that act on the joint, shape (k, m, p, a)
    torque: np.ndarray  # products with the torque to explain, shape (k, m, p)
    errors: np.ndarray  # products with the residual when the other blocks predict it, shape (k, m, p)


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Columns of i candidates, p each, after a fit of the prediction's unknowns to all blocks.

    Only products of columns enter the solutions, so their cost does not grow with the rows of a block.
    """

    prediction: Prediction  # prediction without the candidates
    acting: dict[int, ActingOn]  # columns by joint
    products: np.ndarray  # products with the unknowns over fitted blocks, shape (i, p, b)
    whitened: np.ndarray  # these products, whitened, shape (i, p, b)
    matrix: np.ndarray  # normal matrices of the coefficients, shape (i, p, p)
    right: np.ndarray  # right-hand sides, shape (i, p)

    @classmethod
    def of(cls, prediction: Prediction, alike: Sequence[Thinned]) -> "Eliminated":
        """Eliminate the unknowns of a prediction from candidates with the same number of columns."""
        shape = len(alike), alike[0].values.shape[2]
        products, matrix = np.zeros((*shape, len(prediction.rows.std))), np.zeros((*shape, shape[1]))
        right, by_joint, fitted = np.zeros(shape), _by_joint(prediction, alike), prediction.blocks.fitted
        for joint, (members, _, *each_block) in by_joint.items():
            squares, with_unknowns, torque, _ = (block[fitted].sum(axis=0) for block in each_block)
            places = members[:, None, None], np.arange(shape[1])[:, None], prediction.sums.acting[joint]
            products[places] += with_unknowns
            matrix[members] += squares
            right[members] += torque
        whitened, eliminated = products @ prediction.root.T, right - products @ prediction.values
        return cls(prediction, by_joint, products, whitened, matrix - gram(whitened), eliminated)

    def decrease(self, coefficients: np.ndarray) -> np.ndarray:
        """Decrease of the unknowns, shape (i, b), with coefficients (i, p)."""
        return combined(coefficients, self.whitened) @ self.prediction.root

    def left_out(self, fits: Fitted) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (k, i, p) without each block, and the decrease of the unknowns with them, (k, i, b)."""
        prediction, fitted = self.prediction, self.prediction.blocks.fitted
        each, unknowns = (int(fitted.sum()), *self.right.shape), prediction.left_out[fitted]
        whitened = np.zeros((*each, unknowns.shape[1]))
        matrix, right = np.zeros((*each, each[2])), np.zeros(each)
        for joint, (members, _, *each_block) in self.acting.items():
            others = (block[fitted].sum(axis=0) - block[fitted] for block in each_block)
            squares, products, torque, _ = others
            places, flat = prediction.sums.acting[joint], products.reshape(each[0], -1, products.shape[3])
            by_root = flat @ prediction.roots_without[joint]
            whitened[:, members] += by_root.reshape(*products.shape[:3], -1)
            matrix[:, members] += squares
            right[:, members] += torque - (flat @ unknowns[:, places, None]).reshape(torque.shape)
        matrix, right = matrix - gram(whitened), right + fits.precision * fits.mean
        # Held-out blocks are predicted by all fitted ones.
        coefficients = np.tile(fits.values, (len(fitted), 1, 1))
        decrease = np.tile(self.decrease(fits.values), (len(fitted), 1, 1))
        coefficients[fitted] = solved(with_diagonal(matrix, fits.precision), right, fits.values, fits.free)
        decrease[fitted] = combined(coefficients[fitted], whitened) @ prediction.root_without
        return coefficients, decrease

    def compared(self, fits: Fitted) -> tuple[np.ndarray, np.ndarray]:
        """Products of each candidate's whitened change of the prediction by other blocks, both (k, i, n).

        The first is the product with the residual, the second that with itself.
        """
        prediction, (coefficients, decrease) = self.prediction, self.left_out(fits)
        linear = np.empty((*decrease.shape[:2], prediction.joints))
        square = np.empty(linear.shape)
        for joint, places in enumerate(prediction.sums.acting):
            unknowns = decrease[:, :, places]
            linear[:, :, joint] = -(unknowns @ prediction.along_errors[joint][:, :, None])[:, :, 0]
            square[:, :, joint] = prediction.squares(joint, unknowns)
            if joint in self.acting:
                members, _, squares, products, _, errors = self.acting[joint]
                own = coefficients[:, members]
                linear[:, members, joint] += np.einsum("kmp,kmp->km", own, errors)
                change = (squares @ own[..., None])[..., 0]
                change -= 2.0 * (products @ unknowns[:, members, :, None])[..., 0]
                square[:, members, joint] += np.einsum("kmp,kmp->km", own, change)
        return linear, np.maximum(square, 0.0)

    def predicted(self, fits: Fitted) -> np.ndarray:
        """Change of the whitened prediction of each block by the others, of one candidate, (k, n, l)."""
        coefficients, decrease = self.left_out(fits)
        change = np.zeros(self.prediction.whitened_errors.shape)
        for joint, (columns, places) in enumerate(
            zip(self.prediction.whitened, self.prediction.sums.acting, strict=True)
        ):
            change[:, joint] = -(columns @ decrease[:, 0, places, None])[:, :, 0]
        for joint, own in self.acting.items():
            change[:, joint] += (own.columns[:, :, 0] @ coefficients[:, 0, :, None])[:, :, 0]
        return change


def _by_joint(prediction: Prediction, alike: Sequence[Thinned]) -> dict[int, ActingOn]:
    """Columns of the candidates that act on each joint."""
    places: dict[int, list[tuple[int, int]]] = {}
    for number, columns in enumerate(alike):
        for place, joint in enumerate(columns.joints.tolist()):
            places.setdefault(joint, []).append((number, place))
    by_joint = {}
    for joint, acting in places.items():
        rows = np.stack([alike[number].values[:, place] for number, place in acting], axis=1)
        rows = prediction.sums.padded(rows * prediction.rows.weight[:, joint, None, None])
        rows *= prediction.scale[:, joint, None, None, None]
        by_joint[joint] = _products(prediction, joint, np.array([number for number, _ in acting]), rows)
    return by_joint


def _products(prediction: Prediction, joint: int, members: np.ndarray, columns: np.ndarray) -> ActingOn:
    """Products of whitened columns (k, l, m, p) of candidates on a joint, in each block."""
    flat = np.swapaxes(columns.reshape(*columns.shape[:2], -1), 1, 2)
    shape = len(columns), *columns.shape[2:]
    torque, errors = prediction.whitened_torque[:, joint], prediction.whitened_errors[:, joint]
    others = flat @ np.stack([torque, errors], axis=2)
    return ActingOn(
        members,
        columns,
        np.einsum("klmp,klmq->kmpq", columns, columns),
        (flat @ prediction.whitened[joint]).reshape(*shape, -1),
        others[:, :, 0].reshape(shape),
        others[:, :, 1].reshape(shape),
    )


def combined(coefficients: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Linear combinations (..., b) of rows (..., p, b); faster than matrix products for few rows."""
    return np.asarray(np.einsum("...p,...pb->...b", coefficients, rows))


def gram(rows: np.ndarray) -> np.ndarray:
    """Products of rows (..., p, b) with each other, shape (..., p, p)."""
    if rows.shape[-2] == 1:  # thousands of matrices of one element
        return np.einsum("...pb,...pb->...p", rows, rows)[..., None]
    return np.asarray(rows @ np.swapaxes(rows, -1, -2))
