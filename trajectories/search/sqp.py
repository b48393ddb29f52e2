"""SQP: minimum of a smooth function of hundreds of variables under thousands of bounds.

Sequential quadratic programming (Nocedal and Wright, Numerical Optimization, chapter 18). Each step minimises
a quadratic model of the Lagrangian under the near bounds made linear, by the dual active-set method of DAQP.
It is shortened until the value and a penalty on the worst violation fall. The curvature of the model comes
from gradients (BFGS, damped as by Powell), and what has been learnt of it with one function serves the next.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import daqp
import numpy as np

NEAR = 0.5
"""Margin, as a share of its room, up to which a bound is a row of the quadratic programme. Of the thousands
of rows of a sampled limit some hundreds are; one that comes nearer is a row of the next step."""
LONGEST = 1.0
"""Change of a variable in one step at most: in a search's units, the most it may be within its limits."""
FARTHER = 3.0
"""How much longer a step may be than the last: one that was shortened shows how far the model holds."""
PENALTY = 1.5
"""Penalty on a violation, over the sum of the multipliers: above one the minimum keeps to the bounds."""
FALL = 1e-4
"""Share of the promised fall that a step must bring (Armijo)."""
HALVINGS = 12
"""Times that a step is shortened at most: it is a thousandth then, or less."""
PATIENCE = 3
"""Steps in a row that gain little, inside the bounds, before a function is left."""
KEPT = 1e-3
"""Violation, as a share of a bound's room, that counts as none."""
DAMPED = 0.2
"""Curvature along a step, as a share of the model's, below which the change of gradient is mixed with it."""
FAR = 1e30
"""No limit, in the solver's words."""


class Function:
    """A function of one array and its slope, computed once where value and slope are asked for in turn.

    Slopes are wanted at the iterates alone, and values at every trial of a step too.
    """

    def __init__(self, function: Callable[[np.ndarray], tuple[Any, Callable[..., np.ndarray]]]) -> None:
        self._function, self._at = function, np.empty(0)

    def value(self, at: np.ndarray) -> Any:
        """Value there."""
        if not np.array_equal(at, self._at):
            self._value, self._slope = self._function(at)
            self._at = at.copy()
        return self._value

    def slope(self, at: np.ndarray, *rows: np.ndarray) -> np.ndarray:
        """Slope there, of some rows where there are many."""
        self.value(at)
        return self._slope(*rows)


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate.

    Attributes:
        at: Variables, shape (n,).
        value: Of the function.
        gradient: Shape (n,).
        margin: At least zero where allowed, shape (r,).
        rows: Near bounds, shape (m,).
        slopes: Of their margins, shape (m, n).
    """

    at: np.ndarray
    value: float
    gradient: np.ndarray
    margin: np.ndarray
    rows: np.ndarray
    slopes: np.ndarray

    @classmethod
    def of(cls, function: Function, margins: Function, at: np.ndarray) -> "Point":
        """Everything there."""
        margin = margins.value(at)
        rows = np.flatnonzero(margin < NEAR)
        return cls(at, function.value(at), function.slope(at), margin, rows, margins.slope(at, rows))

    def pull(self, multipliers: np.ndarray) -> np.ndarray:
        """Gradient of the Lagrangian with multipliers of all bounds, shape (r,)."""
        return np.asarray(self.gradient - multipliers[self.rows] @ self.slopes)


@dataclass(frozen=True, eq=False)
class Step:
    """What the quadratic model proposes.

    Attributes:
        change: Of the variables, shape (n,).
        multipliers: Of all bounds, shape (r,).
        penalty: On the worst violation.
        fall: What the model promises of value and penalty.
    """

    change: np.ndarray
    multipliers: np.ndarray
    penalty: float
    fall: float


def minimise(
    function: Function,
    margins: Function,
    start: np.ndarray,
    curvature: np.ndarray,
    steps: int,
    gain: float,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The iterates on the way to a minimum near a start, each with the curvature learnt until then.

    Args:
        function: What to minimise.
        margins: Of all bounds; at least zero where allowed.
        start: Variables to begin with, shape (n,); they need not keep to the bounds.
        curvature: Of the model to begin with, positive definite, shape (n, n).
        steps: At most.
        gain: Fall of the function in a step that is little.
    """
    here, penalty, reach, fresh = Point.of(function, margins, start), 1.0, LONGEST, False
    falls: deque[float] = deque(maxlen=PATIENCE)
    for _ in range(steps):
        step = _proposed(here, curvature, penalty, reach)
        there = step and _shortened(function, margins, here, step)
        if not step or not there:  # rounding, or a model that is far off: once more without what it learnt
            if fresh:
                break
            curvature, fresh = np.eye(len(start)), True
            continue
        curvature, fresh = _learnt(curvature, here, there, step.multipliers), False
        held = float(np.max(np.abs(step.change))) > 0.99 * reach  # a longer step might have brought more
        falls.append(np.inf if held else _merit(here, step.penalty) - _merit(there, step.penalty))
        reach = min(LONGEST, FARTHER * float(np.max(np.abs(there.at - here.at))))
        here, penalty = there, step.penalty
        yield here.at, curvature
        if len(falls) == PATIENCE and max(falls) < gain and _worst(here.margin) < KEPT:
            break


def _proposed(here: Point, curvature: np.ndarray, penalty: float, reach: float) -> Step | None:
    """Minimum of the model. One more variable is the worst violation that is left, at the penalty's price.

    None where nothing is left to gain, or rounding leaves the solver without an answer.
    """
    margin, count = here.margin[here.rows], len(here.at)
    worst = _worst(here.margin)
    size = count + 1
    hessian, gradient = np.eye(size), np.append(here.gradient, penalty)
    hessian[:count, :count] = curvature
    relief = np.full(len(margin), float(worst > 0.0))
    lower = np.concatenate([np.full(count, -reach), [0.0], -margin])
    upper = np.concatenate([np.full(count, reach), [worst or FAR], np.full(len(margin), FAR)])
    table = np.column_stack([here.slopes, relief])
    found, _, flag, more = daqp.solve(hessian, gradient, table, upper, lower, np.zeros(len(lower), np.int32))
    if flag < 1:
        return None
    multipliers = np.zeros(len(here.margin))
    multipliers[here.rows] = -np.asarray(more["lam"])[size:]
    penalty = max(penalty, PENALTY * float(np.sum(multipliers)))
    fall = penalty * (worst - found[count]) - here.gradient @ found[:count]
    return Step(found[:count], multipliers, penalty, fall) if fall > 0.0 else None


def _worst(margin: np.ndarray) -> float:
    """Of all violations, or zero."""
    return max(0.0, -float(np.min(margin, initial=0.0)))


def _merit(point: Point, penalty: float) -> float:
    return point.value + penalty * _worst(point.margin)


def _shortened(function: Function, margins: Function, here: Point, step: Step) -> Point | None:
    """Where a step leads that brings its share of what it promises; None if none does."""
    share, merit = 1.0, _merit(here, step.penalty)
    for _ in range(HALVINGS):
        at = here.at + share * step.change
        rise = function.value(at) + step.penalty * _worst(margins.value(at)) - merit
        if rise <= -FALL * share * step.fall:
            return Point.of(function, margins, at)
        bend = rise + share * step.fall  # of the parabola through both ends
        share *= min(max(0.5 * share * step.fall / bend, 0.1), 0.6) if np.isfinite(bend) else 0.1
    return None


def _learnt(curvature: np.ndarray, here: Point, there: Point, multipliers: np.ndarray) -> np.ndarray:
    """Curvature with what the change of the Lagrangian's gradient shows of it (Powell's damped BFGS)."""
    step, change = there.at - here.at, there.pull(multipliers) - here.pull(multipliers)
    along = curvature @ step
    modelled, seen = float(step @ along), float(step @ change)
    if modelled <= 0.0:
        return curvature
    if seen < DAMPED * modelled:
        share = (1.0 - DAMPED) * modelled / (modelled - seen)
        change = share * change + (1.0 - share) * along
    updated = curvature + np.outer(change, change) / (step @ change) - np.outer(along, along) / modelled
    return np.asarray(0.5 * (updated + updated.T))
