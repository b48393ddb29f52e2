"""What every clearance must keep: gradients of differences, and bounds that no sample is below."""

import numpy as np

from exidyn.trajectories.clearances.clearance import RESOLUTION


def differences(function, position, step=1e-6):
    """Central differences of (t, m) by each joint, shape (t, m, n)."""
    sides = [
        (function(position + step * unit) - function(position - step * unit)) / (2 * step)
        for unit in np.eye(position.shape[1])
    ]
    return np.stack(sides, axis=-1)


def bound_is_proved(clearance, trajectory):
    """No sample is below the bound, the margin is reached at its time, and both are near each other."""
    found = clearance.worst(trajectory)
    seen = clearance.margins(trajectory.at(np.linspace(0, trajectory.duration, 3001)).position)
    assert found.bound <= np.min(seen) + 1e-9
    assert found.bound <= found.margin <= found.bound + max(RESOLUTION, 0.1 * found.margin) + 1e-9
    again = clearance.margins(trajectory.at(np.array([found.time])).position)[0]
    np.testing.assert_allclose(again[clearance.names.index(found.name)], found.margin, atol=1e-8)
    return found
