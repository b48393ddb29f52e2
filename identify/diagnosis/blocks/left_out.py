"""Left out: what a residual becomes in each block when this block is left out of the fit.

Let A be the rows of a block over their noise, and N the normal matrix of all other blocks and the priors. If
a fit to all blocks leaves the residual u in this block, a fit without it leaves (1 + A N^-1 A') u there. A
block has few rows, so one factor of N serves any number of residuals.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

TALL = 2
"""Rows of a block per unknown from which on two products with a root are faster than one with a matrix."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Operator on residuals of each fitted block."""

    operators: Mapping[int, np.ndarray]  # block -> 1 + A N^-1 A', shape (r, r), if blocks are not tall
    roots: Mapping[int, np.ndarray]  # block -> root of A N^-1 A', shape (r, b), if they are

    @classmethod
    def of(cls, roots: Mapping[int, np.ndarray]) -> "LeftOut":
        """From a root of A N^-1 A' of each fitted block, shape (r, b)."""
        if any(len(root) > TALL * root.shape[1] for root in roots.values()):
            return cls({}, roots)
        return cls({block: np.eye(len(root)) + root @ root.T for block, root in roots.items()}, {})

    def applied(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals (c, k, r) of fits to all blocks, when each block is left out, same shape."""
        left_out = residuals.copy()
        for block, operator in self.operators.items():
            left_out[:, block] = residuals[:, block] @ operator
        for block, root in self.roots.items():
            left_out[:, block] += residuals[:, block] @ root @ root.T
        return left_out
