"""Eliminated: columns of candidates without the part that the unknowns of a prediction explain."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..blocks.prediction import Prediction
from .candidate import Thinned
from .candidate_fit import Fitted, solved, with_diagonal


class ActingOn(NamedTuple):
    """Products of i candidates' whitened columns on one joint, p each, in each block."""

    squares: np.ndarray  # products of the columns, shape (k, i, p, p)
    products: np.ndarray  # products with the unknowns that act on the joint, shape (k, i, p, a)
    torque: np.ndarray  # products with the torque to explain, shape (k, i, p)
    errors: np.ndarray  # products with the residual when the other blocks predict it, shape (k, i, p)

    @classmethod
    def of(cls, prediction: Prediction, joint: int, values: np.ndarray) -> "ActingOn":
        """Products of sorted values (i, p, r) of columns on a joint, zero where a row does not count."""
        sums, shape = prediction.sums, values.shape[:2]
        flat, weight = values.reshape(-1, values.shape[2]), np.square(prediction.scale[:, joint, None, None])
        products = sums.products_of(flat, sums.columns[joint]) * weight
        torque = sums.products_of(flat, sums.torque[joint, :, None]) * weight
        errors = torque - products @ prediction.left_out[:, sums.acting[joint], None]
        each = (products, torque[..., 0], errors[..., 0])
        squares = _squares(prediction, values) * weight[..., None]
        return cls(squares, *(x.reshape(len(weight), *shape, *x.shape[2:]) for x in each))


@dataclass(frozen=True, eq=False)
class Eliminated:
    """Columns of i candidates, p each, after a fit of the prediction's unknowns to all blocks.

    All candidates act on the same joints. Blocks enter by products of columns, whose number does not depend
    on the length of a block.
    """

    prediction: Prediction  # prediction without the candidates
    acting: dict[int, ActingOn]  # columns by joint
    products: np.ndarray  # products with the unknowns over fitted blocks, shape (i, p, b)
    whitened: np.ndarray  # these products, whitened, shape (i, p, b)
    matrix: np.ndarray  # normal matrices of the coefficients, shape (i, p, p)
    right: np.ndarray  # right-hand sides, shape (i, p)

    @classmethod
    def of(cls, prediction: Prediction, alike: Sequence[Thinned]) -> "Eliminated":
        """Eliminate the unknowns of a prediction from candidates with as many columns on the same joints."""
        shape = len(alike), alike[0].values.shape[2]
        products, matrix = np.zeros((*shape, len(prediction.rows.std))), np.zeros((*shape, shape[1]))
        right, by_joint, fitted = np.zeros(shape), dict[int, ActingOn](), prediction.blocks.fitted
        for place, joint in enumerate(alike[0].joints.tolist()):
            values = prediction.sums.sorted([columns.values[:, place].T for columns in alike], joint)
            by_joint[joint] = own = ActingOn.of(prediction, joint, values)
            products[:, :, prediction.sums.acting[joint]] += own.products[fitted].sum(axis=0)
            matrix += own.squares[fitted].sum(axis=0)
            right += own.torque[fitted].sum(axis=0)
        whitened, eliminated = products @ prediction.root.T, right - products @ prediction.values
        return cls(prediction, by_joint, products, whitened, matrix - gram(whitened), eliminated)

    def only(self, chosen: np.ndarray) -> "Eliminated":
        """The chosen candidates alone, by index."""
        acting = {joint: ActingOn(*(array[:, chosen] for array in own)) for joint, own in self.acting.items()}
        arrays = (self.products, self.whitened, self.matrix, self.right)
        return Eliminated(self.prediction, acting, *(array[chosen] for array in arrays))

    def gain(self, fits: Fitted) -> np.ndarray:
        """Gain in log probability of the fitted blocks and all priors with the fitted coefficients, (i,)."""
        values, deviations = fits.values, fits.values - fits.mean
        right = self.right - 0.5 * (self.matrix @ values[..., None])[..., 0]
        return np.asarray(np.sum(values * right - 0.5 * fits.precision * deviations**2, axis=1))

    def decrease(self, coefficients: np.ndarray) -> np.ndarray:
        """Decrease of the unknowns, shape (i, b), with coefficients (i, p)."""
        return combined(coefficients, self.whitened) @ self.prediction.root

    def left_out(self, fits: Fitted) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (k, i, p) without each block, and the decrease (k, i, b) of the unknowns with them."""
        prediction, fitted = self.prediction, self.prediction.blocks.fitted
        values, shape = prediction.left_out[fitted], (np.count_nonzero(fitted), *self.right.shape)
        whitened = np.zeros((*shape, values.shape[1]))
        matrix, right = np.zeros((*shape, shape[2])), np.tile(fits.precision * fits.mean, (shape[0], 1, 1))
        for joint, own in self.acting.items():
            squares, products, torque = (
                block[fitted].sum(axis=0) - block[fitted] for block in (own.squares, own.products, own.torque)
            )
            flat = products.reshape(shape[0], -1, products.shape[3])
            unknowns = values[:, prediction.sums.acting[joint], None]
            whitened += (flat @ prediction.roots_without[joint]).reshape(whitened.shape)
            matrix += squares
            right += torque - (flat @ unknowns).reshape(shape)
        matrix = with_diagonal(matrix - gram(whitened), fits.precision)
        # Held-out blocks are predicted by all fitted ones.
        coefficients = np.tile(fits.values, (len(fitted), 1, 1))
        decrease = np.tile(self.decrease(fits.values), (len(fitted), 1, 1))
        coefficients[fitted] = solved(matrix, right, fits.values, fits.free)
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
            if own := self.acting.get(joint):
                change = own.squares @ coefficients[..., None] - 2.0 * own.products @ unknowns[..., None]
                linear[:, :, joint] += (coefficients * own.errors).sum(axis=2)
                square[:, :, joint] += (coefficients * change[..., 0]).sum(axis=2)
        return linear, np.maximum(square, 0.0)

    def predicted(self, fits: Fitted, columns: Thinned) -> np.ndarray:
        """Change of the prediction of each block by the others, of one candidate, sorted (n, r) [N m]."""
        sums, (coefficients, decrease) = self.prediction.sums, self.left_out(fits)
        change = -sums.torque_of([decrease[:, 0, places] for places in sums.acting])
        for place, joint in enumerate(columns.joints.tolist()):
            [values] = sums.sorted([columns.values[:, place].T], joint)
            change[joint] += np.einsum("rp,pr->r", sums.by_row(coefficients[:, 0]), values)
        return change


def _squares(prediction: Prediction, columns: np.ndarray) -> np.ndarray:
    """Products of sorted columns (i, p, r) of each candidate in each block, shape (k, i, p, p)."""
    if columns.shape[1] == 1:
        return prediction.sums.sums(np.square(columns[:, 0]))[..., None, None]
    return np.stack([gram(columns[:, :, rows]) for rows in prediction.sums.spans])


def combined(coefficients: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Linear combinations (..., b) of rows (..., p, b); faster than matrix products for few rows."""
    return np.asarray(np.einsum("...p,...pb->...b", coefficients, rows))


def gram(rows: np.ndarray) -> np.ndarray:
    """Products of rows (..., p, b) with each other, shape (..., p, p)."""
    if rows.shape[-2] == 1:  # thousands of matrices of one element
        return np.einsum("...pb,...pb->...p", rows, rows)[..., None]
    return np.asarray(rows @ np.swapaxes(rows, -1, -2))
