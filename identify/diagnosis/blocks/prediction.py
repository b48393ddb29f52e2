"""Prediction: every block, predicted from all other blocks and the priors with a given set of columns."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import positive_definite
from ...positive_definite import Factor, solve, whitening
from ...preparation.repeated_motion import repeated_share
from ..runs.rows import Rows
from .block_likelihood import common_variance, independent_share, log_probability, trust
from .blocks import BlockRows, Blocks

TURNS = 6
"""Maximum number of iterations over unknowns, noise and trust."""
SETTLED = 0.02
"""Change of a log variance below which iterations stop."""
ROUNDING = 1e-9
"""Regularization, relative to a column's square, that keeps undetermined unknowns at zero."""
CERTAIN = 1e-12
"""Standard deviation that stands for an unknown held at its prior mean."""
LINEAR = 0.03
"""Relative error of a measured torque [-]: current sensors are linear to a few percent."""
UNKNOWN = 1e3
"""Factor on a prior's standard deviation that stands for no prior."""


@dataclass(frozen=True, eq=False)
class Weighting:
    """Weights of blocks and joints."""

    variance: np.ndarray  # mean squared error of a predicted row of each joint, (n,) [(N m)^2]
    trust: np.ndarray  # weight of each block, (k, n); zero for held-out blocks
    independent: np.ndarray  # independent rows over all rows of each joint, (n,)

    @property
    def weight(self) -> np.ndarray:
        """Weight of each block and joint in the fit, shape (k, n); correlated rows count for fewer."""
        return self.independent * self.trust / self.variance


@dataclass(frozen=True, eq=False)
class Prediction:
    """Least squares with priors, each block left out in turn."""

    rows: Rows  # rows of the fitted runs, then of the held-out runs
    blocks: Blocks  # blocks of the rows
    rate: float  # rate of the rows [Hz]
    sums: BlockRows  # rows that count, block by block
    weighting: Weighting  # weights of blocks and joints
    nominal: np.ndarray | None = None  # errors of the baseline, (k, n) [(N m)^2]; None if this is it

    @classmethod
    def of(
        cls,
        rows: Rows,
        blocks: Blocks,
        rate: float,
        similar: Weighting | None = None,
        sums: BlockRows | None = None,
        nominal: np.ndarray | None = None,
    ) -> "Prediction":
        """Estimate noise and trust from the rows, starting from those of a similar model if given."""
        sums = sums or BlockRows.of(rows, blocks)
        fitted, counts = blocks.fitted[:, None].astype(float), sums.counts
        total = np.maximum((counts * fitted).sum(axis=0), 1.0)
        weighting = similar or Weighting(
            (sums.sums(np.square(sums.torque)) * fitted).sum(axis=0) / total + 1e-30,
            fitted + 0.0 * counts,
            np.ones(counts.shape[1]),
        )
        for turn in range(TURNS + 1):
            now = cls(rows, blocks, rate, sums, weighting, nominal)
            variance = rows.row_variance(np.sum(now.errors * weighting.trust, axis=0) / total + 1e-30)
            settled = np.all(np.abs(np.log(variance / weighting.variance)) < SETTLED)
            first = turn == 0 and similar is None
            if turn == TURNS or (settled and not first):
                break
            # Held-out runs must not influence the weights of fitted runs.
            residual = sums.in_sequence(sums.residual(now.values) * sums.by_row(fitted).T)
            independent = independent_share(residual, rows.runs, rate) * repeated_share(
                residual, blocks.first
            )
            trusted = trust(independent * now.errors * fitted, independent * counts * fitted) * fitted
            weighting = Weighting(variance, weighting.trust if first else trusted, independent)
        return now

    @property
    def joints(self) -> int:
        """Number of joints."""
        return self.rows.difference.shape[1]

    @cached_property
    def scale(self) -> np.ndarray:
        """Square root of the weight of each block and joint, (k, n); held-out blocks count as fitted."""
        if_fitted = self.weighting.independent / self.weighting.variance
        return np.sqrt(np.where(self.blocks.fitted[:, None], self.weighting.weight, if_fitted))

    @cached_property
    def _block_equations(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrices (k, b, b) and right-hand sides (k, b) of each fitted block, k of them."""
        fitted, count = self.blocks.fitted, len(self.rows.std)
        matrices, right = np.zeros((fitted.sum(), count, count)), np.zeros((fitted.sum(), count))
        scales, sums = np.square(self.scale[fitted]).T, self.sums
        for joint, acting in enumerate(sums.acting):
            scale = scales[joint][:, None]
            matrices[:, acting[:, None], acting] += scale[:, None] * sums.squares[joint][fitted]
            right[:, acting] += scale * sums.products[joint][fitted]
        return matrices, right

    @cached_property
    def precision(self) -> np.ndarray:
        """Inverse variance of each unknown's prior, shape (b,); zero without a prior."""
        return 1.0 / np.maximum(self.rows.std, CERTAIN) ** 2

    @cached_property
    def normal(self) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrix (b, b) and right-hand side (b,) of all fitted blocks and the priors."""
        matrices, right = (blocks.sum(axis=0) for blocks in self._block_equations)
        return matrices + np.diag(self.precision), right + self.precision * self.rows.mean

    @cached_property
    def factor(self) -> Factor:
        """Factor of the normal matrix."""
        return factored(self.normal[0])

    @cached_property
    def stated(self) -> np.ndarray:
        """Which unknowns have a prior and are not held at it, shape (b,)."""
        return np.isfinite(self.rows.std) & (self.rows.std > CERTAIN)

    @cached_property
    def values(self) -> np.ndarray:
        """Unknowns fitted to all fitted blocks, shape (b,)."""
        return solve(self.factor, self.normal[1])

    @cached_property
    def factors(self) -> dict[int, Factor]:
        """Fitted block -> factor of the normal matrix without it."""
        fitted, matrices = np.flatnonzero(self.blocks.fitted).tolist(), self._block_equations[0]
        return {k: factored(self.normal[0] - own) for k, own in zip(fitted, matrices, strict=True)}

    @cached_property
    def root(self) -> np.ndarray:
        """Root W (b, b) of the inverse of the normal matrix, which is W' W."""
        return whitening(self.factor)

    @cached_property
    def root_of_blocks(self) -> np.ndarray:
        """Root of the inverse of the normal matrix without the priors of `stated` unknowns, shape (b, b)."""
        precision = np.where(self.stated, UNKNOWN**-2, 1.0) * self.precision
        return whitening(factored(self._block_equations[0].sum(axis=0) + np.diag(precision)))

    @cached_property
    def limited_std(self) -> np.ndarray:
        """Standard deviations of the unknowns that physics limits, shape (l,)."""
        places = self.rows.limited
        return np.sqrt(np.diag(solve(self.factor, np.eye(len(self.rows.std))[:, places])[places]))

    @cached_property
    def limited_size(self) -> np.ndarray:
        """RMS torque over all rows per unit of the unknowns that physics limits, shape (l,)."""
        return rms_torque(self.rows.columns_at(self.rows.limited))

    @cached_property
    def root_without(self) -> np.ndarray:
        """Roots of the inverse normal matrices without each of k fitted blocks, shape (k, b, b)."""
        return np.stack([whitening(factor) for factor in self.factors.values()])

    @cached_property
    def roots_without(self) -> list[np.ndarray]:
        """These roots, transposed, of the unknowns that act on each joint, [n] of (k, a, b)."""
        return [np.swapaxes(self.root_without[:, :, acting], 1, 2).copy() for acting in self.sums.acting]

    def squares(self, joint: int, unknowns: np.ndarray) -> np.ndarray:
        """Squared whitened torque (k, c) on a joint of c sets of unknowns that act on it, (k, c, a)."""
        scale = np.square(self.scale[:, joint, None])
        return np.einsum("kca,kca->kc", unknowns @ self.sums.squares[joint], unknowns) * scale

    @cached_property
    def along_errors(self) -> list[np.ndarray]:
        """Products of whitened columns with the residual of predicted blocks, by joint, [n] of (k, a)."""
        sums, weight = self.sums, np.square(self.scale)
        each = zip(sums.squares, sums.products, sums.acting, weight.T[..., None], strict=True)
        return [
            scale * (products - (squares @ self.left_out[:, acting, None])[..., 0])
            for squares, products, acting, scale in each
        ]

    @cached_property
    def left_out(self) -> np.ndarray:
        """Unknowns fitted without each block, shape (k, b)."""
        values = np.tile(self.values, (len(self.blocks), 1))
        rights = self.normal[1] - self._block_equations[1]
        for (block, factor), right in zip(self.factors.items(), rights, strict=True):
            values[block] = solve(factor, right)
        return values

    @cached_property
    def errors(self) -> np.ndarray:
        """Sum of squared errors of each block when the others predict it, shape (k, n) [(N m)^2]."""
        return self.sums.errors(self.left_out)

    @cached_property
    def residual(self) -> np.ndarray:
        """Residual of the fit, shape (r, n) [N m]."""
        return self.rows.difference - self.rows.torque(self.values)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance of the unknowns (b, b): that of the jackknife plus that of the uncertain priors."""
        replicates = self.left_out[self.blocks.fitted]
        deviations = replicates - replicates.mean(axis=0)
        nominal = solve(self.factor, np.diag(np.sqrt(self.precision)))
        jackknife = (len(replicates) - 1.0) / len(replicates) * deviations.T @ deviations
        return jackknife + nominal @ nominal.T

    def power(self, errors: np.ndarray, blocks: np.ndarray | None = None) -> np.ndarray:
        """Mean squared error per row, from errors (..., k, n) of chosen blocks (k,), (..., n) [(N m)^2]."""
        chosen = np.ones(len(self.blocks), bool) if blocks is None else blocks
        return errors[..., chosen, :].sum(axis=-2) / np.maximum(self.sums.counts[chosen].sum(axis=0), 1.0)

    def log_probability(self, errors: np.ndarray, independent: np.ndarray) -> np.ndarray:
        """Log probability of prediction errors (..., k, n), given the share of independent rows (n,).

        Sensors are only linear to `LINEAR`, so that share of the explained torque counts as error. Rows of a
        passive joint scatter at least as much as those of a motor.
        """
        nominal, counts = self.errors if self.nominal is None else self.nominal, self.sums.counts
        wrong = LINEAR**2 * np.maximum(nominal - errors, 0.0)
        if self.rows.passive:
            passive, scatter = list(self.rows.passive), self.rows.row_variance(self.power(nominal))
            wrong[..., passive] += scatter[passive] * counts[:, passive]
        return log_probability(independent * (errors + wrong), independent * counts)

    @cached_property
    def log_probability_now(self) -> np.ndarray:
        """Log probability of the blocks as predicted, at the residual's independent rows, shape (k, n)."""
        return self.log_probability(self.errors, self.weighting.independent)

    def common_variance(self, errors: np.ndarray, independent: np.ndarray) -> np.ndarray:
        """Common variance of errors (..., k, n), given the share of independent rows (n,), (..., n)."""
        return common_variance(independent * errors, independent * self.sums.counts)

    def independent_of(self, torque: np.ndarray) -> np.ndarray:
        """Independent rows over all rows (n,) for the torque (r, n) of a new effect, unknowns refitted."""
        torque = torque * self.rows.weight
        mixed = self.sums.mixed(self.weighting.weight[self.blocks.number] * torque, len(self.rows.std))
        residual = self.sums.in_sequence(self.sums.residual(self.values - solve(self.factor, mixed))) - torque
        share = independent_share(residual, self.rows.runs, self.rate, torque)
        return share * repeated_share(residual, self.blocks.first)


def rms_torque(columns: np.ndarray) -> np.ndarray:
    """RMS over rows, summed over joints, of columns (r, n, p), shape (p,) [N m / unit]."""
    return np.asarray(np.sqrt(np.einsum("rnp,rnp->p", columns, columns) / max(len(columns), 1)))


def factored(matrix: np.ndarray) -> Factor:
    """Factor of a normal matrix, columns scaled to one; unknowns that no row determines stay at zero."""
    return positive_definite.factored(matrix, ROUNDING)
