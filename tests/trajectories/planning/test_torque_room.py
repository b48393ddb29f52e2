"""Room below torque limits for what is not known of the arm, less after a fit."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.planning.goals import learned, torque_spread
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan_check import nominal_torque

from ...parts.plans.excitation import TICK, limits, weak
from ...parts.small.small_fit import plain_fit

pytestmark = pytest.mark.slow

WISHES = Wishes(harmonics=2, period=4.0, seconds=6.2, tick=TICK, rest=0.5)


NEEDED = (60.0, 17.0)
"""Torque limits that the nominal arm needs all of [N m]."""


def planned(model, **wishes):
    (one,) = plan(model, replace(WISHES, **wishes), starts=1, seconds=1e6)
    return one


def share_beyond(model, one, seed=11):
    """Of arms drawn here, their torque at every tick."""
    std = np.array([prior.std for prior in model.priors])
    random = np.random.default_rng(seed).normal(size=(len(std), 1000))
    drawn = model.nominal_values[:, None] + np.where(np.isfinite(std), std, 0.0)[:, None] * random
    torque = model.regressor(one.trajectory.every(TICK).motion()) @ drawn
    return np.mean(np.any(np.abs(torque) > model.robot.limits.torque[:, None], axis=(0, 1)))


def used(model, one):
    """Largest share of a torque limit that the nominal torque of a motion uses."""
    return nominal_torque(one, model).use.share.max()


def test_drawn_arms_stay_inside_the_torque_limits():
    model = weak((54.0, 15.0), inertial_tolerance=0.3)
    safe, nominal = planned(model), planned(model, sure=0.0)
    assert share_beyond(model, safe) <= 0.05 < share_beyond(model, nominal)
    assert safe.details["torque"].startswith("within limits for 95 % of the arms that the priors allow; ")
    assert "torque" not in nominal.details


def test_a_fit_gives_freedom():
    model, fit = weak(NEEDED, inertial_tolerance=0.3), plain_fit()
    first, later = planned(model), planned(model, fit=fit)
    assert used(model, first) < 0.7 < used(learned(fit), later) <= 0.95
    assert "the arms that the fit allows" in later.details["torque"]


def test_no_room_is_made_where_none_is_wished_or_needed():
    model, unlimited = weak(NEEDED, inertial_tolerance=0.3), replace(limits(), torque=np.full(2, np.inf))
    assert torque_spread(model, limits(), ("",), 0.0) is None
    assert torque_spread(model, unlimited, ("",), 0.95) is None


def test_an_arm_too_little_known_to_be_held_is_refused():
    with pytest.raises(Infeasible, match="margin for 95 % of the possible arms"):
        planned(weak((20.0, 20.0), inertial_tolerance=1.0))
