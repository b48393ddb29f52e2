"""Left out: what a residual becomes in each block when this block is left out of the fit.

Let A be the rows of a block over their noise, and N the normal matrix of all other blocks and the priors. If
a fit to all blocks leaves the residual u in this block, a fit without it leaves (1 + A N^-1 A') u there. So
one factor of N serves any number of residuals.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Operator on residuals of each fitted block."""

    columns: Sequence[np.ndarray]  # rows A of all blocks, by joint, [n] of (k, l, a)
    acting: Sequence[np.ndarray]  # unknowns of these columns, [n] of (a,)
    inverses: Mapping[int, np.ndarray]  # fitted block -> N^-1, shape (b, b)

    def applied(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals (c, k, n, l) of fits to all blocks, when each block is left out, same shape."""
        left_out = residuals.copy()
        if self._short:
            for block, operator in self._operators.items():
                rows = residuals[:, block].reshape(len(residuals), -1)
                left_out[:, block] = (rows @ operator).reshape(left_out[:, block].shape)
            return left_out
        for block, inverse in self.inverses.items():
            products = np.zeros((len(residuals), len(inverse)))
            for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
                products[:, acting] += residuals[:, block, joint] @ columns[block]
            unknowns = products @ inverse
            for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
                left_out[:, block, joint] += unknowns[:, acting] @ columns[block].T
        return left_out

    @cached_property
    def _short(self) -> bool:
        """Whether a product with 1 + A N^-1 A' is faster than products with A', N^-1 and A."""
        rows = sum(columns.shape[1] for columns in self.columns)
        unknowns = sum(columns.shape[1] * columns.shape[2] for columns in self.columns)
        return all(rows**2 < len(inverse) ** 2 + 2 * unknowns for inverse in self.inverses.values())

    @cached_property
    def _operators(self) -> dict[int, np.ndarray]:
        """1 + A N^-1 A' of each fitted block, shape (n l, n l)."""
        operators = {}
        for block, inverse in self.inverses.items():
            rows = np.zeros((len(self.columns), self.columns[0].shape[1], len(inverse)))
            for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
                rows[joint][:, acting] = columns[block]
            dense = rows.reshape(-1, len(inverse))
            operators[block] = np.eye(len(dense)) + dense @ inverse @ dense.T
        return operators
