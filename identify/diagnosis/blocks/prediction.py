"""Prediction: every block as all other blocks and the priors predict it, with the columns at hand."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import positive_definite
from ...positive_definite import Factor, solve, whitening
from ..runs.rows import Rows
from .block_likelihood import common_variance, independent_share, log_probability, trust
from .blocks import Blocks, BlockSums

TURNS = 6
"""Times that unknowns, noise and trust are found in turn, at most."""
SETTLED = 0.02
"""Change of the logarithm of a variance that is not worth another turn."""
ROUNDING = 1e-9
"""Share of a column's square that keeps unknowns that no row determines at zero."""
CERTAIN = 1e-12
"""Standard deviation of an unknown that is held at its prior; a number for the computer."""
LINEAR = 0.03
"""Share by which a torque may be wrong all over [-]: current sensors are linear to a few per cent."""
UNKNOWN = 1e3
"""Standard deviations of a prior over its own in place of none; a number for the computer."""


@dataclass(frozen=True, eq=False)
class Weighting:
    """What each block and joint counts for."""

    variance: np.ndarray  # squared error of a predicted row of each joint, (n,) [(N m)^2]
    trust: np.ndarray  # weight of each block, (k, n); zero where it is only predicted
    independent: np.ndarray  # independent rows over all rows of each joint, (n,)

    @property
    def weight(self) -> np.ndarray:
        """Weight of each block and joint in the fit, shape (k, n): rows that repeat the same count once."""
        return self.independent * self.trust / self.variance


@dataclass(frozen=True, eq=False)
class Prediction:
    """Least squares of priors and blocks, each block left out in turn."""

    rows: Rows  # what is fitted, runs that are only predicted behind those that are
    blocks: Blocks  # its pieces
    rate: float  # of the rows [Hz]
    sums: BlockSums  # products over the blocks
    weighting: Weighting  # of blocks and joints
    nominal: np.ndarray | None = None  # errors without findings, (k, n) [(N m)^2]; None for its own

    @classmethod
    def of(
        cls,
        rows: Rows,
        blocks: Blocks,
        rate: float,
        near: Weighting | None = None,
        sums: BlockSums | None = None,
        nominal: np.ndarray | None = None,
    ) -> "Prediction":
        """With noise and trust estimated from the rows; that begins with those of a like model, if given."""
        sums = sums or BlockSums.of(rows, blocks)
        fitted, counts = blocks.fitted[:, None].astype(float), sums.counts
        total = np.maximum((counts * fitted).sum(axis=0), 1.0)
        weighting = near or Weighting(
            (sums.square * fitted).sum(axis=0) / total + 1e-30,
            fitted + 0.0 * counts,
            np.ones(counts.shape[1]),
        )
        for turn in range(TURNS):
            now = cls(rows, blocks, rate, sums, weighting)
            variance = rows.row_variance(np.sum(now.errors * weighting.trust, axis=0) / total + 1e-30)
            settled = np.all(np.abs(np.log(variance / weighting.variance)) < SETTLED)
            # Runs that are only predicted do not show what others are worth.
            independent = independent_share(sums.left(now.values) * fitted[blocks.number], rows.runs, rate)
            trusted = trust(independent * now.errors * fitted, independent * counts * fitted) * fitted
            first = turn == 0 and near is None
            weighting = Weighting(variance, weighting.trust if first else trusted, independent)
            if settled and not first:
                break
        return cls(rows, blocks, rate, sums, weighting, nominal)

    @property
    def joints(self) -> int:
        """How many there are."""
        return self.rows.difference.shape[1]

    @cached_property
    def _whole(self) -> tuple[np.ndarray, np.ndarray]:
        return self.sums.whole(self.weighting.weight, len(self.rows.std))

    @cached_property
    def precision(self) -> np.ndarray:
        """Inverse variance of each unknown's prior, shape (b,); zero where nothing is known."""
        return 1.0 / np.maximum(self.rows.std, CERTAIN) ** 2

    @cached_property
    def normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrix (b, b) and right-hand side (b,) of all fitted blocks and the priors."""
        gram, right = self._whole
        return gram.sum(axis=0) + np.diag(self.precision), right.sum(axis=0) + self.precision * self.rows.mean

    @cached_property
    def factor(self) -> Factor:
        """Factor of the normal matrix."""
        return factored(self.normal[0])

    @cached_property
    def stated(self) -> np.ndarray:
        """Which unknowns have a prior that leaves them open, shape (b,)."""
        return np.isfinite(self.rows.std) & (self.rows.std > CERTAIN)

    @cached_property
    def factor_of_blocks(self) -> Factor:
        """Factor of the normal matrix without those priors."""
        precision = np.where(self.stated, UNKNOWN**-2, 1.0) * self.precision
        return factored(self._whole[0].sum(axis=0) + np.diag(precision))

    @cached_property
    def values(self) -> np.ndarray:
        """Unknowns by all fitted blocks, shape (b,)."""
        return solve(self.factor, self.normal[1])

    @cached_property
    def factors(self) -> list[Factor]:
        """Factors of the normal matrix without each block."""
        return [factored(self.normal[0] - gram) for gram in self._whole[0]]

    @cached_property
    def root(self) -> np.ndarray:
        """Root W (b, b) of the inverse of the normal matrix, which is W' W."""
        return whitening(self.factor)

    @cached_property
    def roots(self) -> np.ndarray:
        """The same of the normal matrix without each block, shape (k, b, b)."""
        return np.array([whitening(factor) for factor in self.factors])

    @cached_property
    def root_of_blocks(self) -> np.ndarray:
        """The same of the normal matrix without priors that leave unknowns open."""
        return whitening(self.factor_of_blocks)

    @cached_property
    def limited_std(self) -> np.ndarray:
        """Standard deviations of the unknowns that physics limits, shape (l,)."""
        places = self.rows.limited
        return np.sqrt(np.diag(solve(self.factor, np.eye(len(self.rows.std))[:, places])[places]))

    @cached_property
    def limited_size(self) -> np.ndarray:
        """Torque per unit of the same, root mean square over all rows, shape (l,)."""
        return rms_torque(self.rows.columns[:, :, self.rows.limited])

    @cached_property
    def left_out(self) -> np.ndarray:
        """Unknowns by all blocks but each, shape (k, b)."""
        right = self.normal[1] - self._whole[1]
        return np.array([solve(factor, own) for factor, own in zip(self.factors, right, strict=True)])

    @cached_property
    def slopes(self) -> list[np.ndarray]:
        """Products of columns and what the others' prediction leaves of each block, [n] of (k, a)."""
        sums, values = self.sums, self.left_out
        return [
            right - np.einsum("kab,kb->ka", gram, values[:, acting])
            for gram, right, acting in zip(sums.gram, sums.right, sums.acting, strict=True)
        ]

    @cached_property
    def errors(self) -> np.ndarray:
        """Sum of squares of each block as the others predict it, shape (k, n) [(N m)^2]."""
        return self.sums.errors(self.left_out)

    @cached_property
    def residual(self) -> np.ndarray:
        """What the fit leaves, shape (r, n) [N m]."""
        return self.rows.difference - self.rows.columns @ self.values

    @cached_property
    def left_out_residual(self) -> np.ndarray:
        """What the others' prediction leaves of each block, shape (r, n) [N m]."""
        left = self.rows.difference.copy()
        for rows, values in zip(self.blocks.rows, self.left_out, strict=True):
            left[rows] -= self.rows.columns[rows] @ values
        return left

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of the unknowns (b, b): the jackknife's, and that of nominal values as wrong as stated."""
        own = self.left_out[self.blocks.fitted]
        apart = own - own.mean(axis=0)
        nominal = solve(self.factor, np.diag(np.sqrt(self.precision)))
        return (len(own) - 1.0) / len(own) * apart.T @ apart + nominal @ nominal.T

    def power(self, errors: np.ndarray, which: np.ndarray | None = None) -> np.ndarray:
        """Mean square of predicted errors (..., k, n) of some blocks (k,), shape (..., n) [(N m)^2]."""
        chosen = np.ones(len(self.blocks), bool) if which is None else which
        return errors[..., chosen, :].sum(axis=-2) / np.maximum(self.sums.counts[chosen].sum(axis=0), 1.0)

    def log_probability(self, errors: np.ndarray, independent: np.ndarray) -> np.ndarray:
        """Log probability of predicted errors (..., k, n), of whose rows so many are independent (n,).

        What is explained is right to the linearity of the sensors only: less than that decides nothing.
        Rows of a passive joint scatter no less than a motor's do.
        """
        nominal, counts = self.errors if self.nominal is None else self.nominal, self.sums.counts
        wrong = LINEAR**2 * np.maximum(nominal - errors, 0.0)
        if self.rows.passive:
            passive, scatter = list(self.rows.passive), self.rows.row_variance(self.power(nominal))
            wrong[..., passive] += scatter[passive] * counts[:, passive]
        return log_probability(independent * (errors + wrong), independent * counts)

    @cached_property
    def log_probability_now(self) -> np.ndarray:
        """Log probability of the blocks as they are predicted, by the rows that its residual has, (k, n)."""
        return self.log_probability(self.errors, self.weighting.independent)

    def common_variance(self, errors: np.ndarray, independent: np.ndarray) -> np.ndarray:
        """Variance that predicted errors (..., k, n) share, of whose rows so many are independent (n,)."""
        return common_variance(independent * errors, independent * self.sums.counts)

    def independent_of(self, torque: np.ndarray) -> np.ndarray:
        """Independent rows over all rows (n,) for further torque (r, n), all unknowns solved anew."""
        torque = torque * self.rows.weight
        mixed = self.sums.mixed(self.weighting.weight[self.blocks.number] * torque, len(self.rows.std))
        residual = self.sums.left(self.values - solve(self.factor, mixed)) - torque
        return independent_share(residual, self.rows.runs, self.rate, torque)


def rms_torque(columns: np.ndarray) -> np.ndarray:
    """Root mean square over rows, all joints together, of columns (r, n, p), shape (p,)."""
    return np.asarray(np.sqrt(np.einsum("rnp,rnp->p", columns, columns) / max(len(columns), 1)))


def factored(matrix: np.ndarray) -> Factor:
    """Factor of a normal matrix, its columns scaled to one; what no row determines stays at zero."""
    return positive_definite.factored(matrix, ROUNDING)
