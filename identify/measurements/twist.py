"""Twist: how far a motor that moves as recorded leads a link that follows on its gear.

With motors where their encoders measure, every link but one follows its motor, and that one leads or lags
by a twist whose equation is row j of the arm's: M_jj twist'' + d twist' + (K + dtau_j/dq_j) twist = load_j.
What all motors give for it more than for a rigid gear is minus the links' torque for a twist.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arm.derivatives import differentiate

CHUNK = 200
"""Rows that are made plain at once."""

SOFTEST = 1e-3
"""Least stiffness of gear and gravity together, over their largest: so soft that it explains nothing."""


class Twist(NamedTuple):
    """How far a motor leads its link, with derivatives, each of shape (t,) [rad], [rad/s], [rad/s^2]."""

    value: np.ndarray
    rate: np.ndarray
    second: np.ndarray


def bent(
    inertia: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, load: np.ndarray, step: float
) -> Twist:
    """Twist of an elastic gear: inertia'' + damping' + stiffness = load, at each sample with its own numbers.

    Newmark's average acceleration, which is stable however stiff the gear is. All steps are one banded
    system; it begins as if the load had always been what it is at the start. Inertia [kg m^2], damping
    [N m s/rad], stiffness [N m/rad] and load [N m] are those of the link, (t,), in steps of time [s].
    """
    # A first fit may leave a light link less than no inertia where a payload's moments are unknown, and a
    # soft gear cannot carry any payload: such a gear would have no twist at all, or one without bound.
    # Its Coriolis torque, which gains no energy beside a change of the inertia, would without one.
    if np.min(inertia) < 0.0:
        inertia, damping = np.maximum(inertia, 0.0), np.maximum(damping, 0.0)
    stiffness = np.maximum(stiffness, SOFTEST * np.max(np.abs(stiffness)))
    mass, loss = inertia / step**2, damping / (2 * step)
    bands = np.zeros((3, len(load)))
    # Row k is the equation at sample k - 1; by the first two rows the gear starts at rest.
    bands[0, 2:] = (mass + loss + stiffness / 4)[1:-1]
    bands[1, 1:-1] = (stiffness / 2 - 2 * mass)[1:-1]
    bands[2, :-2] = (mass - loss + stiffness / 4)[1:-1]
    bands[0, :2] = 1.0
    right = np.empty(len(load))
    right[:2] = load[0] / stiffness[0]
    right[2:] = (load[:-2] + 2 * load[1:-1] + load[2:]) / 4
    from scipy.linalg import solve_banded  # large, and readers of files have little memory

    value = solve_banded((2, 0), bands, right, check_finite=False)
    rate, second = differentiate(value[:, None], 1.0 / step)
    return Twist(value, rate[:, 0], second[:, 0])


def loose(
    inertia: np.ndarray,
    damping: np.ndarray,
    stiffness: np.ndarray,
    load: np.ndarray,
    step: float,
    play: float,
    teeth: tuple[float, float],
    on_teeth: Twist | None = None,
) -> Twist:
    """Twist of a gear with play: within it, nothing but the link's own inertia answers the load.

    A link rests against the teeth that its load is on, as if they were rigid, or bent as given where they are
    soft; when the load changes its sign, it floats to the other side, strikes, and bounces until the teeth
    have damped it out.

    Inertia, damping, stiffness (by gravity) and load are those of the link without its gear, as in `bent`.
    The play is half of its width [rad]. The teeth are the link's resonance on them, at most an eighth of the
    sample rate [Hz], and its damping ratio [-]. On soft teeth their twist without any play is `on_teeth`.
    """
    angular, ratio = 2 * np.pi * teeth[0], teeth[1]
    settled = int(3.0 / (ratio * angular * step))  # e^-3, a twentieth of the stroke, is left then
    side = np.where(load < 0, -1.0, 1.0)
    value, rate, second = play * side, np.zeros(len(load)), np.zeros(len(load))
    if on_teeth is not None:
        value, rate, second = value + on_teeth.value, on_teeth.rate.copy(), on_teeth.second.copy()
    per_inertia = np.stack([load, damping, stiffness], axis=1) / inertia[:, None]
    end = 0
    for start in (np.flatnonzero(np.diff(side)) + 1).tolist():
        if start < end:
            continue
        x, v, in_contact, path = float(value[start - 1]), float(rate[start - 1]), 0, []
        # Plain numbers: a sample depends on the one before, and arrays of one number are slow.
        for pull, drag, weight in _rows(per_inertia, start):
            past = x - play if x > play else x + play if x < -play else 0.0
            acceleration = pull - drag * v - weight * x
            if past:
                acceleration -= angular * (angular * past + 2.0 * ratio * v)
                in_contact += 1
            else:
                in_contact = 0
            v += step * acceleration
            x += step * v
            path.append((x, v, acceleration))
            if in_contact > settled and past * pull > 0.0:
                break
        end = start + len(path)
        value[start:end], rate[start:end], second[start:end] = np.array(path).T
    return Twist(value, rate, second)


def resting(load: np.ndarray, play: float) -> Twist:
    """Twist of a link that rests on the side of its load (t,) [N m]; the play is half of its width [rad]."""
    still = np.zeros(len(load))
    return Twist(np.where(load < 0, -play, play), still, still)


def _rows(values: np.ndarray, start: int) -> Iterator[list[float]]:
    """Rows of (t, p) as plain numbers from one on, a second or so at a time."""
    for first in range(start, len(values), CHUNK):
        yield from values[first : first + CHUNK].tolist()
