r"""Prediction of efforts, block by block, by bodies of any mass and by effects that no description contains.

The effort of joint :math:`j` is :math:`y_j = X_j \beta + Z_j \alpha_j + n_j`. The first term is the torque of
bodies and stated effects, common to all joints. The second is rotor, friction and offset of the joint, and a
discrepancy: torque that depends on position, direction, speed and the neighbors' motion. A prior limits the
discrepancy to about a tenth of the effort, so that cables or unusual friction are no evidence against a
correct log.

Each block is predicted from the others in two ways: `coupled` uses one :math:`\beta` for all joints and the
stated gains; `single` uses a separate :math:`\beta` for each joint, so that its gain is free.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from ..arm.motion import Motion
from .samples import Sampled

FOLDS = 5
"""Number of blocks, each predicted from the others."""
RIDGES = (1e-2, 1e-4, 1e-7)
"""Candidate ridge parameters of a body's column: noise variance over column variance. Each hypothesis uses
the one that predicts best; with too large a ridge, right bodies would explain less than wrong ones."""
OWN_RIDGES = (1.0, 1e-1, 1e-2)
"""Candidate ridge parameters for a single joint, which determines bodies less well than all joints do."""
FREE, HELD_BACK = 1e-4, 0.3
"""Ridge parameters of rotor, friction and offset, which may have any size, and of the discrepancy: noise of a
twentieth of the effort over terms of a tenth of it."""
POSITION_WAVES, DIRECTION_WAVES = 6, 4
"""Number of half waves over a joint's range in torque that depends on position, and in torque that also
changes sign with direction."""
NOTHING = 1e-12
"""Size of a column, relative to the largest, below which it counts as zero."""


def _discrepancy_columns(motion: Motion, joint: int) -> np.ndarray:
    """Torque that depends on a joint's position, direction and speed, and on its neighbors, shape (t, k)."""
    position, velocity = motion.position[:, joint], motion.velocity[:, joint]
    direction = np.sign(velocity)
    share = (position - position.min()) / max(float(np.ptp(position)), NOTHING)
    speed = np.abs(velocity) / max(float(np.abs(velocity).max()), NOTHING)
    columns = [np.cos(np.pi * k * share) for k in range(1, POSITION_WAVES + 1)]
    columns += [direction * np.cos(np.pi * k * share) for k in range(1, DIRECTION_WAVES + 1)]
    columns += [speed, np.sqrt(speed), direction * np.sqrt(speed), direction * speed**2]
    neighbors = [k for k in (joint - 1, joint + 1) if 0 <= k < motion.position.shape[1]]
    for k in neighbors:
        columns += [motion.velocity[:, k], np.sign(motion.velocity[:, k])]
    return np.stack(columns, axis=1)


def joint_columns(motion: Motion, joint: int) -> np.ndarray:
    """Terms of a joint alone: rotor and friction, offset, and discrepancy, shape (t, q)."""
    velocity = motion.velocity[:, joint]
    friction = np.stack([motion.acceleration[:, joint], velocity, np.sign(velocity)], axis=1)
    return np.hstack([friction, np.ones((len(motion), 1)), _discrepancy_columns(motion, joint)])


class Block(NamedTuple):
    """One block of samples, with the normal equations of all other blocks for each joint."""

    rows: np.ndarray  # samples of the block
    # Products of the bodies' columns after elimination of the joint's terms, shape (n, p, p).
    schur: np.ndarray
    across: np.ndarray  # joint terms per unit of each body's column, shape (n, q, p)
    inverse: np.ndarray  # inverse of the regularized products of the joint's terms, shape (n, q, q)
    size: np.ndarray  # sum of squares of each body's column, shape (n, p)


@dataclass(frozen=True)
class BlockPrediction:
    """Columns of a motion for the prediction of efforts."""

    # Torque per unit of each body's parameter, zero where a joint may stick, shape (n, t, p).
    bodies: np.ndarray
    terms: np.ndarray  # terms of each joint alone, normalized to root mean square 1, shape (n, t, q)
    sliding: np.ndarray  # 1 where a joint slides, else 0, shape (t, n)

    @classmethod
    def of(cls, columns: np.ndarray, log: Sampled) -> "BlockPrediction":
        """Prediction from columns (t, n, p) of bodies and stated effects at the samples of a log."""
        n, sliding = columns.shape[1], log.sliding.astype(float)
        parts = [joint_columns(log.motion, j) * sliding[:, j : j + 1] for j in range(n)]
        width = max(part.shape[1] for part in parts)
        terms = np.stack([np.pad(part, ((0, 0), (0, width - part.shape[1]))) for part in parts])
        size = np.sqrt((terms**2).mean(axis=1, keepdims=True))
        terms = np.divide(terms, size, out=np.zeros_like(terms), where=size > NOTHING)
        moved = columns.any(axis=(0, 1))  # links without torque on any joint have zero columns
        bodies = (columns[:, :, moved] * sliding[:, :, None]).transpose(1, 0, 2)
        return cls(np.ascontiguousarray(bodies), terms, sliding)

    @cached_property
    def blocks(self) -> list[Block]:
        """All blocks with their normal equations."""
        folds = np.array_split(np.arange(self.bodies.shape[1]), FOLDS)
        parts = []
        for rows in folds:
            bodies, terms = self.bodies[:, rows], self.terms[:, rows]
            across = bodies.transpose(0, 2, 1)
            parts.append([across @ bodies, across @ terms, terms.transpose(0, 2, 1) @ terms])
        total = [np.sum([part[k] for part in parts], axis=0) for k in range(3)]
        weight = np.concatenate([np.full(4, FREE), np.full(self.terms.shape[2] - 4, HELD_BACK)])
        blocks = []
        for rows, part in zip(folds, parts, strict=True):
            products, cross, squares = (
                all_blocks - block for all_blocks, block in zip(total, part, strict=True)
            )
            held_back = (self.bodies.shape[1] - len(rows)) * np.diag(weight)
            inverse = np.linalg.inv(squares + held_back)
            across = inverse @ cross.transpose(0, 2, 1)
            size = np.einsum("jpp->jp", products)
            blocks.append(Block(rows, products - cross @ across, across, inverse, size))
        return blocks

    def coupled(self, effort: np.ndarray) -> np.ndarray:
        """Unpredicted share of each effort (t, n) with common bodies for all joints, shape (n,)."""
        values, scale = self._normal(effort)
        missed = np.zeros((len(RIDGES), len(scale)))
        for block, (reduced, known) in zip(self.blocks, self._right(values, scale), strict=True):
            matrix = np.tensordot(scale**2, block.schur, axes=1)
            betas = _solved(matrix, reduced.sum(axis=0), scale**2 @ block.size, RIDGES)
            missed += self._missed(block, values, scale, known, betas)
        return _best(self._shares(missed, values))

    def single(self, effort: np.ndarray) -> np.ndarray:
        """Unpredicted share of each effort (t, n) with separate bodies for each joint, shape (n,)."""
        values, scale = self._normal(effort)
        missed = np.zeros((len(OWN_RIDGES), len(scale)))
        squares = scale[:, None] ** 2
        for block, (reduced, known) in zip(self.blocks, self._right(values, scale), strict=True):
            beta = _solved(squares[:, :, None] * block.schur, reduced, squares * block.size, OWN_RIDGES)
            missed += self._missed(block, values, scale, known, beta)
        return np.asarray(self._shares(missed, values).min(axis=0))

    def fitted(self, effort: np.ndarray) -> np.ndarray:
        """Residual share of each effort (t, n) after a fit of each joint to all samples, shape (n,)."""
        values, scale = self._normal(effort)
        columns = np.concatenate([self.bodies * scale[:, None, None], self.terms], axis=2)
        products = columns.transpose(0, 2, 1) @ columns
        size = np.einsum("jpp->jp", products)
        beta = _solved(products, columns.transpose(0, 2, 1) @ values, size, RIDGES[:1])[0]
        return self._shares(((values - columns @ beta) ** 2).sum(axis=1).T, values)[0]

    def _normal(self, effort: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Efforts (n, t, 1) standardized over sliding samples, and 1 / std of each effort, shape (n,)."""
        count = np.maximum(self.sliding.sum(axis=0), 1.0)
        values = (effort - (effort * self.sliding).sum(axis=0) / count) * self.sliding
        std = np.sqrt((values**2).sum(axis=0) / count)
        # A constant effort carries no information.
        scale = np.divide(1.0, std, out=np.zeros_like(std), where=std > 1e-9 * std.max())
        return (values * scale).T[:, :, None], scale

    def _right(self, values: np.ndarray, scale: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Right-hand sides (n, p, 1) and joint terms (n, q, 1) from all blocks except one, for each block."""
        parts = [
            (
                self.bodies[:, block.rows].transpose(0, 2, 1) @ values[:, block.rows],
                self.terms[:, block.rows].transpose(0, 2, 1) @ values[:, block.rows],
            )
            for block in self.blocks
        ]
        products, along = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1))
        for block, (of_bodies, of_terms) in zip(self.blocks, parts, strict=True):
            others = along - of_terms
            reduced = (products - of_bodies) - block.across.transpose(0, 2, 1) @ others
            yield scale[:, None, None] * reduced, block.inverse @ others

    def _missed(
        self, block: Block, values: np.ndarray, scale: np.ndarray, known: np.ndarray, beta: np.ndarray
    ) -> np.ndarray:
        """Squared prediction error of a block's efforts, shape (ridges, n)."""
        bodies = scale[:, None, None] * np.moveaxis(beta[..., 0], 0, -1)
        alpha = known - block.across @ bodies
        residual = (
            values[:, block.rows] - self.bodies[:, block.rows] @ bodies - self.terms[:, block.rows] @ alpha
        )
        return np.asarray((residual**2).sum(axis=1).T)

    def _shares(self, missed: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Squared errors as shares of the squared efforts, shape (ridges, n)."""
        return np.minimum(missed / np.maximum((values**2).sum(axis=(1, 2)), NOTHING), 1.0)


Trees = list[tuple[np.ndarray, BlockPrediction]]
"""Joints of each tree of bodies on the base, and their prediction: the legs of a robot are independent."""


def trees_of(columns: np.ndarray, log: Sampled) -> Trees:
    """Predictions of a robot from columns (t, n, p) of bodies and stated effects at the samples of a log."""
    whole = BlockPrediction.of(columns, log)
    used = np.asarray(whole.bodies.any(axis=1))
    number, labels = connected_components(used.astype(int) @ used.T.astype(int), directed=False)
    trees = []
    for joints in (np.flatnonzero(labels == tree) for tree in range(number)):
        bodies = np.ascontiguousarray(whole.bodies[joints][:, :, used[joints].any(axis=0)])
        trees.append((joints, BlockPrediction(bodies, whole.terms[joints], whole.sliding[:, joints])))
    return trees


def _solved(matrix: np.ndarray, right: np.ndarray, size: np.ndarray, ridges: Sequence[float]) -> np.ndarray:
    """Ridge solutions (ridges, ..., p, 1) of normal equations; `size` has each column's sum of squares."""
    root = np.sqrt(np.maximum(size, NOTHING * size.max(initial=0.0) + 1e-300))[..., None]
    scaled = matrix / (root * np.swapaxes(root, -1, -2))
    identity = np.eye(scaled.shape[-1])
    return np.array([np.linalg.solve(scaled + ridge * identity, right / root) / root for ridge in ridges])


def _best(shares: np.ndarray) -> np.ndarray:
    """Shares (n,) at the ridge that predicts all joints best, from shares (ridges, n)."""
    return np.asarray(min(shares, key=lambda share: float(np.log(share + 1e-3).sum())))
