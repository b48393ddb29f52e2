r"""How well bodies of any mass predict efforts, block by block, beside what no description has.

The effort of joint :math:`j` is :math:`y_j = X_j \beta + Z_j \alpha_j + n_j`: bodies and stated effects,
common to all joints, and rotor, friction and offset of the joint with a discrepancy: torque that depends on
position, direction and speed, and on the neighbors' motion. The discrepancy is held back to about a tenth of
the effort, so that cables or unusual friction are no evidence against a right log.

Two predictions of each block from the others: `coupled`, one :math:`\beta` for all joints with the gains as
they are stated, and `single`, a :math:`\beta` for each joint, which leaves its gain open.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from ..arm.motion import Motion
from .samples import Sampled

FOLDS = 5
"""Blocks, each predicted from the others."""
RIDGES = (1e-2, 1e-4, 1e-7)
"""Variance of the noise over that of a body's column, as it may be; the one that predicts best is taken, of
each hypothesis: right bodies, held back too much, explain less than wrong ones."""
OWN_RIDGES = (1.0, 1e-1, 1e-2)
"""The same of one joint alone, which tells less of its bodies; each joint has its best one."""
FREE, HELD_BACK = 1e-4, 0.3
"""The same of rotor, friction and offset, which may be of any size, and of the discrepancy: noise of a
twentieth of the effort over terms of a tenth of it."""
POSITION_WAVES, DIRECTION_WAVES = 6, 4
"""Half waves over a joint's range in a torque of position, and in one that changes sign with direction."""
NOTHING = 1e-12
"""Size of a column relative to the largest, below which it is zero."""


def friction_columns(motion: Motion, joint: int) -> np.ndarray:
    """Rotor inertia, viscous and Coulomb friction of a joint, each of size 1, shape (t, 3)."""
    velocity = motion.velocity[:, joint]
    return np.stack([motion.acceleration[:, joint], velocity, np.sign(velocity)], axis=1)


def discrepancy_columns(motion: Motion, joint: int) -> np.ndarray:
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


class Block(NamedTuple):
    """Samples of one block, and what all others say, of each joint and in units of each joint's torque.

    Attributes:
        rows: Samples of the block.
        schur: Products of the bodies' columns where the joint's own terms are fitted too, shape (n, p, p).
        across: The joint's own terms that go with a unit of each column, shape (n, q, p).
        inverse: Inverse products of the joint's own terms, held back, shape (n, q, q).
        size: Squares of each column, shape (n, p).
    """

    rows: np.ndarray
    schur: np.ndarray
    across: np.ndarray
    inverse: np.ndarray
    size: np.ndarray


@dataclass(frozen=True)
class ArmPrediction:
    """Predictions of each tree of bodies that the base carries: the joints of a leg say nothing of another.

    Attributes:
        trees: Joints of each tree, and their columns.
    """

    trees: tuple[tuple[np.ndarray, "BlockPrediction"], ...]

    @classmethod
    def of(cls, columns: np.ndarray, log: Sampled) -> "ArmPrediction":
        """The prediction by columns (t, n, p) of bodies and stated effects, at the samples of a log."""
        prediction = BlockPrediction.of(columns, log)
        used = np.asarray(prediction.bodies.any(axis=1))
        number, labels = connected_components(used.astype(int) @ used.T.astype(int), directed=False)
        trees = []
        for tree in range(number):
            joints = np.flatnonzero(labels == tree)
            bodies = np.ascontiguousarray(prediction.bodies[joints][:, :, used[joints].any(axis=0)])
            trees.append(
                (joints, BlockPrediction(bodies, prediction.terms[joints], prediction.sliding[:, joints]))
            )
        return cls(tuple(trees))

    def coupled(self, effort: np.ndarray) -> np.ndarray:
        """Shares of efforts (t, n) that one set of bodies for all joints does not predict, shape (n,)."""
        return self._each(effort, BlockPrediction.coupled)

    def single(self, effort: np.ndarray) -> np.ndarray:
        """Shares of efforts (t, n) that bodies of its own for each joint do not predict, shape (n,)."""
        return self._each(effort, BlockPrediction.single)

    def fitted(self, effort: np.ndarray) -> np.ndarray:
        """Shares of efforts (t, n) that a fit of each joint to all samples leaves, shape (n,)."""
        return self._each(effort, BlockPrediction.fitted)

    def _each(
        self, effort: np.ndarray, method: Callable[["BlockPrediction", np.ndarray], np.ndarray]
    ) -> np.ndarray:
        shares = np.zeros(effort.shape[1])
        for joints, prediction in self.trees:
            shares[joints] = method(prediction, effort[:, joints])
        return shares


@dataclass(frozen=True)
class BlockPrediction:
    """Columns of a motion, to predict efforts by.

    Attributes:
        bodies: Torque per unit of each body's parameter, zero where a joint may stick, shape (n, t, p).
        terms: Terms of each joint alone, of root mean square 1, shape (n, t, q).
        sliding: 1 where a joint slides, else 0, shape (t, n).
    """

    bodies: np.ndarray
    terms: np.ndarray
    sliding: np.ndarray

    @classmethod
    def of(cls, columns: np.ndarray, log: Sampled) -> "BlockPrediction":
        """The prediction by columns (t, n, p) of bodies and stated effects, at the samples of a log."""
        n, sliding = columns.shape[1], log.sliding.astype(float)
        parts = [_terms(log.motion, j) * sliding[:, j : j + 1] for j in range(n)]
        width = max(part.shape[1] for part in parts)
        terms = np.stack([np.pad(part, ((0, 0), (0, width - part.shape[1]))) for part in parts])
        size = np.sqrt((terms**2).mean(axis=1, keepdims=True))
        terms = np.divide(terms, size, out=np.zeros_like(terms), where=size > NOTHING)
        moved = columns.any(axis=(0, 1))  # links that no joint moves or weighs have no column
        bodies = (columns[:, :, moved] * sliding[:, :, None]).transpose(1, 0, 2)
        return cls(np.ascontiguousarray(bodies), terms, sliding)

    @cached_property
    def blocks(self) -> list[Block]:
        """All blocks."""
        folds = np.array_split(np.arange(self.bodies.shape[1]), FOLDS)
        parts = [_products(self.bodies[:, rows], self.terms[:, rows]) for rows in folds]
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
        """Shares of efforts (t, n) that one set of bodies for all joints does not predict, shape (n,)."""
        values, scale = self._normal(effort)
        missed = np.zeros((len(RIDGES), len(scale)))
        for block, (reduced, known) in zip(self.blocks, self._right(values, scale), strict=True):
            matrix = np.tensordot(scale**2, block.schur, axes=1)
            betas = _solved(matrix, reduced.sum(axis=0), scale**2 @ block.size, RIDGES)
            missed += self._missed(block, values, scale, known, betas)
        return _best(self._shares(missed, values))

    def single(self, effort: np.ndarray) -> np.ndarray:
        """Shares of efforts (t, n) that bodies of its own for each joint do not predict, shape (n,)."""
        values, scale = self._normal(effort)
        missed = np.zeros((len(OWN_RIDGES), len(scale)))
        squares = scale[:, None] ** 2
        for block, (reduced, known) in zip(self.blocks, self._right(values, scale), strict=True):
            beta = _solved(squares[:, :, None] * block.schur, reduced, squares * block.size, OWN_RIDGES)
            missed += self._missed(block, values, scale, known, beta)
        return np.asarray(self._shares(missed, values).min(axis=0))

    def fitted(self, effort: np.ndarray) -> np.ndarray:
        """Shares of efforts (t, n) that a fit of each joint to all samples leaves, shape (n,)."""
        values, scale = self._normal(effort)
        columns = np.concatenate([self.bodies * scale[:, None, None], self.terms], axis=2)
        products = columns.transpose(0, 2, 1) @ columns
        size = np.einsum("jpp->jp", products)
        beta = _solved(products, columns.transpose(0, 2, 1) @ values, size, RIDGES[:1])[0]
        return self._shares(((values - columns @ beta) ** 2).sum(axis=1).T, values)[0]

    def _normal(self, effort: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Efforts (n, t, 1) about their mean and over their standard deviation where sliding, and 1 / std."""
        count = np.maximum(self.sliding.sum(axis=0), 1.0)
        values = (effort - (effort * self.sliding).sum(axis=0) / count) * self.sliding
        std = np.sqrt((values**2).sum(axis=0) / count)
        # An effort that does not change says nothing.
        scale = np.divide(1.0, std, out=np.zeros_like(std), where=std > 1e-9 * std.max())
        return (values * scale).T[:, :, None], scale

    def _right(self, values: np.ndarray, scale: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yields, for each block, right-hand sides (n, p, 1) of the others and their own terms (n, q, 1)."""
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
        """Squares of a block's efforts that bodies and own terms do not predict, shape (ridges, n)."""
        bodies = scale[:, None, None] * np.moveaxis(beta[..., 0], 0, -1)
        alpha = known - block.across @ bodies
        residual = (
            values[:, block.rows] - self.bodies[:, block.rows] @ bodies - self.terms[:, block.rows] @ alpha
        )
        return np.asarray((residual**2).sum(axis=1).T)

    def _shares(self, missed: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Shares (ridges, n) of the squares of efforts."""
        return np.minimum(missed / np.maximum((values**2).sum(axis=(1, 2)), NOTHING), 1.0)


def _terms(motion: Motion, joint: int) -> np.ndarray:
    friction = friction_columns(motion, joint)
    return np.hstack([friction, np.ones((len(friction), 1)), discrepancy_columns(motion, joint)])


def _products(bodies: np.ndarray, terms: np.ndarray) -> list[np.ndarray]:
    """Products of a block's columns, of each joint."""
    across = bodies.transpose(0, 2, 1)
    return [across @ bodies, across @ terms, terms.transpose(0, 2, 1) @ terms]


def _solved(matrix: np.ndarray, right: np.ndarray, size: np.ndarray, ridges: Sequence[float]) -> np.ndarray:
    """Solutions (ridges, ..., p, 1) of normal equations, whose columns have squares `size`."""
    root = np.sqrt(np.maximum(size, NOTHING * size.max(initial=0.0) + 1e-300))[..., None]
    scaled = matrix / (root * np.swapaxes(root, -1, -2))
    identity = np.eye(scaled.shape[-1])
    return np.array([np.linalg.solve(scaled + ridge * identity, right / root) / root for ridge in ridges])


def _best(shares: np.ndarray) -> np.ndarray:
    """Shares (ridges, n) at the ridge that predicts all joints best."""
    return np.asarray(min(shares, key=lambda share: float(np.log(share + 1e-3).sum())))
