"""SQP: minimum of a smooth function of hundreds of variables under thousands of bounds.

Sequential quadratic programming (Nocedal and Wright, Numerical Optimization, chapter 18). Each step minimizes
a quadratic model of the Lagrangian under the linearized near bounds, by the dual active-set method of DAQP.
The step is shortened until the value plus a penalty on the worst violation decreases. The Hessian of the
model is learned from gradients (BFGS with Powell's damping), and that of one function initializes the next.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import daqp
import numpy as np

NEAR = 0.5
"""Margin, as a share of its room, up to which a bound is a row of the quadratic program: some hundreds of the
thousands of rows of a sampled limit. A bound that comes nearer is a row of the next step."""
LONGEST = 1.0
"""Largest change of a variable in one step: in a search's units, its largest value within the limits."""
FARTHER = 3.0
"""Largest ratio of a step's length to the last: a shortened step shows how far the model holds."""
PENALTY = 1.5
"""Penalty on a violation over the sum of the multipliers: above one, the minimum keeps the bounds."""
FALL = 1e-4
"""Share of the predicted decrease that a step must achieve (Armijo)."""
HALVINGS = 12
"""Maximum number of times that a step is shortened, to a thousandth or less."""
PATIENCE = 3
"""Number of consecutive steps with little gain, inside the bounds, after which the search ends."""
KEPT = 1e-3
"""Violation, as a share of a bound's room, that counts as none."""
DAMPED = 0.2
"""Curvature along a step, as a share of the model's, below which the change of gradient is damped."""
FAR = 1e30
"""Value that means no limit to the solver."""


class Function:
    """A function of one array and its slope, cached for the last argument.

    The slope is needed at the iterates only, the value also at every trial of a step.
    """

    def __init__(self, function: Callable[[np.ndarray], tuple[Any, Callable[..., np.ndarray]]]) -> None:
        self._function, self._at = function, np.empty(0)

    def value(self, at: np.ndarray) -> Any:
        """Value at a point."""
        if not np.array_equal(at, self._at):
            self._value, self._slope = self._function(at)
            self._at = at.copy()
        return self._value

    def slope(self, at: np.ndarray, *rows: np.ndarray) -> np.ndarray:
        """Slope at a point, optionally of some rows only."""
        self.value(at)
        return self._slope(*rows)


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate."""

    at: np.ndarray  # variables, shape (n,)
    value: float  # value of the function
    gradient: np.ndarray  # gradient of the function, shape (n,)
    margin: np.ndarray  # margins of all bounds, at least zero where allowed, shape (r,)
    rows: np.ndarray  # indices of the near bounds, shape (m,)
    slopes: np.ndarray  # gradients of the margins of near bounds, shape (m, n)

    @classmethod
    def of(cls, function: Function, margins: Function, at: np.ndarray) -> "Point":
        """Evaluate function and margins at a point."""
        margin = margins.value(at)
        rows = np.flatnonzero(margin < NEAR)
        return cls(at, function.value(at), function.slope(at), margin, rows, margins.slope(at, rows))

    def pull(self, multipliers: np.ndarray) -> np.ndarray:
        """Gradient of the Lagrangian for multipliers of all bounds, shape (r,)."""
        return np.asarray(self.gradient - multipliers[self.rows] @ self.slopes)


@dataclass(frozen=True, eq=False)
class Step:
    """Step that minimizes the quadratic model."""

    change: np.ndarray  # change of the variables, shape (n,)
    multipliers: np.ndarray  # multipliers of all bounds, shape (r,)
    penalty: float  # penalty on the worst violation
    fall: float  # predicted decrease of the value plus penalty


def minimize(
    function: Function, margins: Function, start: np.ndarray, curvature: np.ndarray, steps: int, gain: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Iterates toward a local minimum, each with the Hessian learned so far.

    Args:
        function: Function to minimize.
        margins: Margins of all bounds, at least zero where allowed.
        start: Initial variables, shape (n,), which need not keep the bounds.
        curvature: Initial Hessian of the model, positive definite, shape (n, n).
        steps: Maximum number of steps.
        gain: Decrease of the function in a step below which it counts as little.
    """
    here, penalty, reach, fresh = Point.of(function, margins, start), 1.0, LONGEST, False
    falls: deque[float] = deque(maxlen=PATIENCE)
    for _ in range(steps):
        step = _proposed(here, curvature, penalty, reach)
        there = step and _shortened(function, margins, here, step)
        if not step or not there:  # rounding, or an inaccurate model: retry once with a new Hessian
            if fresh:
                break
            curvature, fresh = np.eye(len(start)), True
            continue
        curvature, fresh = _updated_hessian(curvature, here, there, step.multipliers), False
        held = float(np.max(np.abs(step.change))) > 0.99 * reach  # a longer step might have gained more
        falls.append(np.inf if held else _merit(here, step.penalty) - _merit(there, step.penalty))
        reach = min(LONGEST, FARTHER * float(np.max(np.abs(there.at - here.at))))
        here, penalty = there, step.penalty
        yield here.at, curvature
        if len(falls) == PATIENCE and max(falls) < gain and _worst(here.margin) < KEPT:
            break


def _proposed(here: Point, curvature: np.ndarray, penalty: float, reach: float) -> Step | None:
    """Minimum of the model, with the remaining worst violation as an extra variable that costs the penalty.

    The result is None if nothing can be gained, or if the solver fails due to rounding.
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
    solution, _, flag, more = daqp.solve(
        hessian, gradient, table, upper, lower, np.zeros(len(lower), np.int32)
    )
    if flag < 1:
        return None
    multipliers = np.zeros(len(here.margin))
    multipliers[here.rows] = -np.asarray(more["lam"])[size:]
    penalty = max(penalty, PENALTY * float(np.sum(multipliers)))
    fall = penalty * (worst - solution[count]) - here.gradient @ solution[:count]
    return Step(solution[:count], multipliers, penalty, fall) if fall > 0.0 else None


def _worst(margin: np.ndarray) -> float:
    """Worst of all violations, or zero."""
    return max(0.0, -float(np.min(margin, initial=0.0)))


def _merit(point: Point, penalty: float) -> float:
    return point.value + penalty * _worst(point.margin)


def _shortened(function: Function, margins: Function, here: Point, step: Step) -> Point | None:
    """Point after the step, shortened until the decrease is sufficient; None if it never is."""
    share, merit = 1.0, _merit(here, step.penalty)
    for _ in range(HALVINGS):
        at = here.at + share * step.change
        rise = function.value(at) + step.penalty * _worst(margins.value(at)) - merit
        if rise <= -FALL * share * step.fall:
            return Point.of(function, margins, at)
        bend = rise + share * step.fall  # curvature of the parabola through both ends
        share *= min(max(0.5 * share * step.fall / bend, 0.1), 0.6) if np.isfinite(bend) else 0.1
    return None


def _updated_hessian(curvature: np.ndarray, here: Point, there: Point, multipliers: np.ndarray) -> np.ndarray:
    """Hessian after Powell's damped BFGS update with the change of the Lagrangian's gradient."""
    step, change = there.at - here.at, there.pull(multipliers) - here.pull(multipliers)
    along = curvature @ step
    predicted, observed = float(step @ along), float(step @ change)
    if predicted <= 0.0:
        return curvature
    if observed < DAMPED * predicted:
        share = (1.0 - DAMPED) * predicted / (predicted - observed)
        change = share * change + (1.0 - share) * along
    updated = curvature + np.outer(change, change) / (step @ change) - np.outer(along, along) / predicted
    return np.asarray(0.5 * (updated + updated.T))
