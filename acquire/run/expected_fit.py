"""What planned motions would identify: the fit of runs on a simulated arm whose values are within the priors.

The simulated arm has the effects of the model, values off by up to their tolerances, and typical drives and
sensors. It lacks the errors of the model of a real arm, whose intervals are wider.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from exidyn.identification.errors import NotExcited
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_warnings import OPEN
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.simulation.simulate import as_built
from exidyn.identification.text_table import NORMAL_95, digits
from exidyn.trajectories.planning.goals import with_bodies
from exidyn.trajectories.plans.plan import Plan

from .simulated import simulated

Known = tuple[tuple[str, float], ...]
LISTED = 8
"""Number of open parameters that are listed, the least determined last."""


@dataclass(frozen=True)
class ExpectedParameter:
    """A base parameter or drive gain of the simulated arm, and how well the motion determines it."""

    name: str  # name of the base parameter, or "gain of" and the joint
    unit: str  # its unit
    true: float  # value of the simulated arm
    estimate: float  # estimate from the simulated runs
    std: float  # standard deviation of the estimate

    @property
    def determined(self) -> bool:
        """Whether the standard deviation is below `OPEN` percent of the value."""
        return 100 * self.std <= OPEN * abs(self.true)

    @property
    def holds(self) -> bool:
        """Whether the 95 % interval contains the true value."""
        return abs(self.estimate - self.true) <= NORMAL_95 * self.std


@dataclass(frozen=True)
class ExpectedFit:
    """How well planned motions determine the parameters of an arm."""

    # Base parameters that are not zero in the simulated arm, and estimated drive gains.
    parameters: tuple[ExpectedParameter, ...]
    condition: float  # condition number of the weighted regressor with unit columns [-]

    @property
    def open(self) -> list[ExpectedParameter]:
        """Parameters that the motions do not determine, the best known first."""
        return sorted((p for p in self.parameters if not p.determined), key=lambda p: p.std / abs(p.true))

    @property
    def sentences(self) -> list[str]:
        """Number of determined parameters, the open ones, and how often the intervals hold."""
        relative = [100 * p.std / abs(p.true) for p in self.parameters if p.determined]
        count, half = len(self.parameters), digits(float(np.median(relative)), 2) if relative else "-"
        lines = [
            f"On a simulated arm, whose values are off by up to their tolerances, {len(relative)} of {count} "
            f"parameters are determined to {OPEN:g} % or better, half of those to {half} %; "
            f"{sum(p.holds for p in self.parameters)} of the {count} 95 % intervals contain the true value. "
            "A real arm also has errors of the model, which widen them"
        ]
        if self.open:
            listed = [f"{p.name} ({digits(100 * p.std / abs(p.true), 2)} %)" for p in self.open[:LISTED]]
            more = len(self.open) - len(listed)
            lines.append(f"Open: {', '.join(listed)}{f', and {more} more' if more else ''}")
        return lines


def expected_fit(
    plans: Sequence[Plan],
    model: Model,
    bodies: Sequence[Known] = (),
    *,
    speed: float = 1.0,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> ExpectedFit:
    """Simulate planned motions, each without payload and with each of the bodies, and identify the arm.

    Raises:
        ExidynError: The arm cannot be simulated, or the motions are too poor to identify it.
    """
    arm, carried = with_bodies(as_built(model), bodies)
    known = dict(zip(carried[1:], bodies, strict=True))
    runs = []
    for number, (plan, name) in enumerate(product(plans, carried)):
        progress(f"simulate run {number + 1} of {len(plans) * len(carried)}")
        payload, run = KnownPayload(name, known[name]) if name else None, f"run {number + 1}"
        runs.append(
            simulated(model, plan, arm, payload, speed=speed, tick=plan.tick, seed=seed + number, name=run)
        )
    progress("identify from them")
    return _expected(identify(runs, drop=False, as_recorded=True), arm)


def _expected(fit: Fit, arm: Model) -> ExpectedFit:
    """Estimates of a fit beside the values of the simulated arm."""
    values = dict(zip(arm.names, arm.nominal_values, strict=True))
    true = fit.base.regrouping @ np.array([values[name] for name in fit.model.names])
    estimate, robot = fit.estimate, arm.robot
    rows = [*zip(fit.names, fit.base.units, true, estimate.values, estimate.std, strict=True)]
    names = [f"gain of {joint}" for joint in robot.joints]
    gains = zip(names, robot.units("N m/A"), robot.drive_gain, estimate.gain, estimate.gain_std, strict=True)
    rows += [row for row, used in zip(gains, estimate.gain_estimated, strict=True) if used]
    scale = float(np.max(np.abs(true), initial=0.0))
    if not scale:
        raise NotExcited("every parameter of the nominal model is zero; state values in the robot file")
    return ExpectedFit(
        tuple(
            ExpectedParameter(name, unit, float(value), float(estimated), float(std))
            for name, unit, value, estimated, std in rows
            if abs(value) > np.finfo(float).eps * scale
        ),
        fit.condition,
    )
