r"""Mistakes in the joints that columns belong to: order, direction, mixtures of two joints.

Each is a matrix that turns recorded positions into those of the joints. Positions, efforts or both may be
affected. If both are, the efforts are those that belong to the recorded coordinates: with
:math:`q = A q'`, virtual work gives :math:`\tau = A^{-T} \tau'`.
"""

from collections.abc import Callable, Iterator
from enum import Enum
from itertools import combinations, permutations

import numpy as np

from ..arm.robot import Robot
from .change import Change
from .mistake import Case, LogFacts

CHAINS = 24
"""Maximum number of permutations of equal chains that are tested, enough for four legs."""
MOTOR_SIDE = "state it: [drive] {matrix} in robot.toml, and import with --motor-side{signals}"
HALVES = (0.5, 1.0)
"""Sum and difference of two joints, or half of these."""


class Side(Enum):
    """Columns that a mistake in the joints affects."""

    BOTH = "columns"
    POSITION = "positions"
    EFFORT = "efforts"

    def change(self, matrix: np.ndarray, gain: np.ndarray | None = None) -> Change:
        """Correction by a matrix from recorded to true positions, shape (n, n).

        Efforts that were exchanged before their gains (n,) were applied have the gains of other joints.
        """
        work = np.linalg.inv(matrix).T
        if gain is not None:
            work = gain[:, None] * work / gain
        if self is Side.POSITION:
            return Change(position=matrix)
        return Change(effort=work) if self is Side.EFFORT else Change(position=matrix, effort=work)


Cases = Callable[[LogFacts], Iterator[Case]]


def turned(side: Side, count: int = 1) -> Cases:
    """Some joints of the opposite direction."""
    words = {
        Side.BOTH: "{} counts the other way: position and effort have the opposite sign",
        Side.POSITION: "the position of {} has the opposite sign",
        Side.EFFORT: "the effort of {} has the opposite sign",
    }[side]

    def cases(facts: LogFacts) -> Iterator[Case]:
        for joints in combinations(facts.moving, count) if count < len(facts.moving) else ():
            names = " and ".join(facts.joints[joint] for joint in joints)
            yield Case(words.format(names), side.change(facts.where(dict.fromkeys(joints, -1.0))), joints)

    return cases


def exchanged(side: Side) -> Cases:
    """Exchanged columns of two joints."""
    what = {Side.BOTH: "all columns", Side.POSITION: "the positions", Side.EFFORT: "the efforts"}[side]

    def cases(facts: LogFacts) -> Iterator[Case]:
        for a, b in _likely_pairs(facts):
            order = np.arange(facts.robot.dof)
            order[[a, b]] = b, a
            words = f"{what} of {facts.joints[a]} and {facts.joints[b]} are exchanged"
            yield Case(words, side.change(_of_order(order), facts.gain), (a, b))

    return cases


def sums(side: Side) -> Cases:
    """The value of a joint that contains that of its neighbor, as of an angle against the ground."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        for parent, child in _neighbors(facts):
            for joint, other in ((child, parent), (parent, child)):
                for sign in (1.0, -1.0):
                    coupling = np.eye(facts.robot.dof)
                    coupling[joint, other] = sign
                    words = _sum_words(facts, side, joint, other, "sum" if sign > 0 else "difference")
                    yield _coupled(facts, side, words, coupling, (joint, other))

    return cases


def coupled_motors(facts: LogFacts) -> Iterator[Case]:
    """Motors that turn with two joints, so that friction and rotor act on a sum of these."""
    plain = np.array_equal(facts.robot.coupling, np.eye(facts.robot.dof))
    for parent, child in _neighbors(facts) if plain else ():
        for sign in (1.0, -1.0):
            coupling = np.eye(facts.robot.dof)
            coupling[child, parent] = sign
            one, two = facts.joints[child], facts.joints[parent]
            words = (
                f"friction of {one} depends on the speed of {two}, as of a motor that turns with both joints"
            )
            cure = f"state it: [drive] {_matrix_words(coupling)} in robot.toml"
            yield Case(words, Change(coupling=coupling), (parent, child), cure)


def differentials(side: Side) -> Cases:
    """Sum and difference of two neighbors in place of the two, as of a differential wrist."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        for a, b in _neighbors(facts):
            for half in HALVES:
                for sign in (1.0, -1.0):
                    coupling = np.eye(facts.robot.dof)
                    coupling[np.ix_([a, b], [a, b])] = half * np.array([[1.0, 1.0], [sign, -sign]])
                    words = (
                        f"the {side.value} of {facts.joints[a]} and {facts.joints[b]} are sum and difference "
                        "of these joints, as of a differential"
                    )
                    yield _coupled(facts, side, words, coupling, (a, b))

    return cases


def orders(side: Side) -> Cases:
    """Columns of all joints in another order."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        n = facts.robot.dof
        plain = np.arange(n)
        ranks = np.array([sorted(facts.joints).index(joint) for joint in facts.joints])
        orders = {
            "are in reverse order": plain[::-1],
            "begin one late": np.roll(plain, 1),
            "begin one early": np.roll(plain, -1),
            "are sorted by name": ranks,
        }
        for words, order in orders.items():
            if n > 2 and not np.array_equal(order, plain):
                yield facts.of_all(f"the {side.value} {words}", side.change(_of_order(order), facts.gain))

    return cases


def exchanged_chains(facts: LogFacts) -> Iterator[Case]:
    """Exchanged columns of whole chains, such as legs."""
    chains = equal_chains(facts.robot)
    usual = tuple(range(len(chains)))
    for place, order in enumerate(permutations(usual)):
        if order == usual or place >= CHAINS:
            continue
        columns = np.arange(facts.robot.dof)
        for chain, other in zip(chains, order, strict=True):
            columns[list(chain)] = chains[other]
        first = [facts.joints[chain[0]] for chain in chains]
        names = " and ".join(first[k] for k in usual if order[k] != k)
        moved = tuple(j for k in usual if order[k] != k for j in chains[k])
        read = ", ".join(first[order.index(k)] for k in usual)
        words = f"whole chains are exchanged: those of {names}; the log has {read}"
        yield Case(words, Side.BOTH.change(_of_order(columns), facts.gain), moved)


def equal_chains(robot: Robot) -> list[list[int]]:
    """Joints of each chain from the base if there are several of the same length, else none."""
    root = list(range(robot.dof))
    for joint, parent in enumerate(_parents(robot)):
        root[joint] = joint if parent < 0 else root[parent]
    chains = [[j for j, base in enumerate(root) if base == start] for start in sorted(set(root))]
    return chains if len(chains) > 1 and len({len(chain) for chain in chains}) == 1 else []


def order_of(change: Change) -> np.ndarray | None:
    """Column of each joint, shape (n,), if a change is another order of all columns; else None."""
    matrix = change.position
    if matrix is None or change.effort is None or not np.array_equal(matrix != 0.0, change.effort != 0.0):
        return None
    order = matrix.argmax(axis=1)
    return order if np.array_equal(matrix, _of_order(order)) else None


def _of_order(order: np.ndarray) -> np.ndarray:
    return np.eye(len(order))[order]


def _parents(robot: Robot) -> list[int]:
    return [int(parent) - 1 for parent in list(robot.kinematics.parents)[1:]]


def _neighbors(facts: LogFacts) -> Iterator[tuple[int, int]]:
    """Moving joints and the joint that carries each of them."""
    for child, parent in enumerate(_parents(facts.robot)):
        if child in facts.moving and parent in facts.moving:
            yield parent, child


def _likely_pairs(facts: LogFacts) -> Iterator[tuple[int, int]]:
    """Pairs of joints that are easily confused: in one chain, or at the same place of equal chains."""
    chains = equal_chains(facts.robot)
    place = {joint: (chain, k) for chain, joints in enumerate(chains) for k, joint in enumerate(joints)}
    for a, b in combinations(facts.moving, 2):
        if not chains or place[a][0] == place[b][0] or place[a][1] == place[b][1]:
            yield a, b


def _sum_words(facts: LogFacts, side: Side, joint: int, other: int, kind: str) -> str:
    one, two = facts.joints[joint], facts.joints[other]
    if side is Side.EFFORT:
        return f"the efforts of {one} and {two} are mixed, as by a linkage whose angle is the {kind} of both"
    words = f"the position of {one} is the {kind} of {one} and {two}"
    return words if side is Side.POSITION else f"{words}, and the efforts belong to these angles"


def _coupled(facts: LogFacts, side: Side, words: str, coupling: np.ndarray, joints: tuple[int, int]) -> Case:
    """Case of recorded positions that are the coupling (n, n) times those of the joints."""
    signals = {Side.BOTH: "", Side.POSITION: " position", Side.EFFORT: " torque"}[side]
    cure = MOTOR_SIDE.format(matrix=_matrix_words(coupling), signals=signals)
    return Case(words, side.change(np.linalg.inv(coupling)), joints, cure)


def _matrix_words(coupling: np.ndarray) -> str:
    rows = ", ".join(f"[{', '.join(f'{x:g}' for x in row)}]" for row in coupling.tolist())
    return f"coupling = [{rows}]"
