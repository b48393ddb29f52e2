"""Plots of a fit: torque over time, friction over velocity, intervals against nominal values."""

from dataclasses import replace

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..fit.agreement import Agreement
from ..fit.fit import Fit
from ..model import Model
from ..text_table import NORMAL_95
from .svg import COLUMNS, Panel, Span, legend, picture, stretch

STRETCH = 60.0
"""Longest time over which a torque with about one swing per second can be read by eye [s]."""
DOTS = 600
"""Number of dots in a friction plot; more would hide one another."""
REACH = 4.5
"""Half width of an interval plot, in standard deviations of the prior."""
ROOM_TEMPERATURE = 25.0
"""Temperature at which temperature-dependent friction is drawn [degC]."""
APPROACH = 1.0
"""Path on which a joint slides before its friction is evaluated, far longer than any presliding [rad]."""


def measured_unit(fit: Fit, joint: int) -> str:
    """Unit of the measured effort: amperes if the drive gains are unknown."""
    return "A" if fit.unscaled else fit.model.robot.units("N m")[joint]


def torque_plot(run: Agreement, robot: Robot, joint: int, columns: int = COLUMNS, unit: str = "") -> str:
    """Measured and predicted torque of a joint, and below them the residual with the noise floor."""
    unit, name = unit or robot.units("N m")[joint], robot.joints[joint]
    shown = informative_stretch(run, joint)
    measured, predicted = run.measured[shown, joint], run.predicted[shown, joint]
    residual, noise = run.residual[:, joint], NORMAL_95 * run.noise[joint]
    sliding = residual[run.weight[:, joint] > 0]  # the residual of a stuck joint would set the scale
    complete = len(measured) == len(residual)
    across = Span.around(run.time, margin=0.0)
    part = Span.around(run.time[shown], margin=0.0)
    above = Panel(part, Span.around(measured, predicted), 64, 22, 560, 122 if complete else 108)
    below = Panel(across, Span.around(sliding, np.array([noise]), zero=True), 64, 154, 560, 86)
    keys = [("measured", "measured"), ("predicted dashed", "predicted"), ("residual", "residual")]
    content = (
        legend(64, 14, [*keys, ("bandkey", "noise, 95 %")])
        + above.axes("", f"torque [{unit}]", x_ticks=not complete)
        + above.line(run.time[shown], measured, "measured", columns)
        + above.line(run.time[shown], predicted, "predicted dashed", columns)
        + below.axes("time [s]", f"residual [{unit}]")
        + below.level(-noise, noise, "band")
        + below.line(run.time, residual, "residual", columns)
    )
    return picture(632, 270, f"{run.run}, {name}: torque and residual over time", content)


def informative_stretch(run: Agreement, joint: int) -> slice:
    """Samples of the run, or of a long run those in the `STRETCH` with the largest residual."""
    return stretch(run.time, run.residual[:, joint] ** 2 * run.weight[:, joint], STRETCH)


def friction_plot(fit: Fit, joint: int) -> str:
    """Friction of a joint over velocity: model curve, and measured torque minus all other model terms."""
    robot = fit.model.robot
    velocity, torque = _friction_dots(fit, joint)
    limit = float(robot.limits.velocity[joint])
    fastest = float(np.max(np.abs(velocity), initial=0.0)) or (limit if np.isfinite(limit) else 1.0)
    grid = velocity_grid(fastest)
    curve, spread = friction_curve(fit, joint, grid)
    low, high = curve - NORMAL_95 * spread, curve + NORMAL_95 * spread
    panel = Panel.single(Span.around(grid, margin=0.03), Span.around(torque, low, high), 350, top=22)
    entries = [("dots", "measured minus other terms")] if len(velocity) else []
    return panel.plot(
        f"{robot.joints[joint]}: friction over velocity",
        (f"velocity [{robot.units('rad/s')[joint]}]", f"friction [{measured_unit(fit, joint)}]"),
        [*entries, ("predicted", "model and 95 %")],
        panel.dots(velocity, torque, "dots"),
        panel.band(grid, low, high, "sure"),
        panel.line(grid, curve, "predicted"),
    )


def velocity_grid(fastest: float) -> np.ndarray:
    """Ascending velocities up to the fastest, dense near zero but without zero itself [rad/s]."""
    slow = np.geomspace(1e-4 * fastest, fastest, 60)
    positive = np.unique(np.concatenate([slow, np.linspace(fastest / 60, fastest, 60)]))
    return np.concatenate([-positive[::-1], positive])


def interval_bar(value: float, std: float, prior: float, tolerance: float) -> str:
    """A value's 95 % interval on the scale of its prior, with the prior interval in gray."""
    if not (np.isfinite(tolerance) and tolerance > 0.0):
        return "no nominal value"
    width, height = 220.0, 16.0
    per_deviation = width / (2 * REACH)
    centre = np.clip((value - prior) / tolerance, -REACH + 0.2, REACH - 0.2)
    half = min(NORMAL_95 * std / tolerance, 2 * REACH)
    low, high = np.clip([centre - half, centre + half], -REACH, REACH)
    outside = abs(value - prior) > (REACH - 0.2) * tolerance
    place = width / 2 + per_deviation * centre
    tip = per_deviation * 0.2 * np.sign(centre)
    mark = (
        f'<path class="value" d="M{place - tip:.1f} 3L{place + tip:.1f} 8L{place - tip:.1f} 13z"/>'
        if outside
        else f'<circle class="value" cx="{place:.1f}" cy="8" r="3"/>'
    )
    x1, x2 = width / 2 + per_deviation * low, width / 2 + per_deviation * high
    prior = per_deviation * NORMAL_95
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" role="img">'
        f'<rect class="prior" x="{width / 2 - prior:.1f}" y="1" width="{2 * prior:.1f}" height="14"/>'
        f'<line class="zero" x1="{width / 2:g}" x2="{width / 2:g}" y1="1" y2="15"/>'
        f'<line class="interval" x1="{x1:.1f}" x2="{x2:.1f}" y1="8" y2="8"/>{mark}</svg>'
    )


def _friction_dots(fit: Fit, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and friction torque of samples in which the joint slides, spread over all runs used."""
    if not fit.agreement:
        return np.zeros(0), np.zeros(0)
    sliding = [run.weight[:, joint] > 0 for run in fit.agreement]
    velocity = np.concatenate([r.velocity[s, joint] for r, s in zip(fit.agreement, sliding, strict=True)])
    residual = np.concatenate([r.residual[s, joint] for r, s in zip(fit.agreement, sliding, strict=True)])
    chosen = np.unique(np.linspace(0, len(velocity) - 1, min(DOTS, len(velocity))).astype(int))
    velocity, residual = velocity[chosen], residual[chosen]
    return velocity, residual + friction_curve(fit, joint, velocity)[0]


def friction_curve(fit: Fit, joint: int, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Friction of one joint that slides alone at velocities (t,) [rad/s], and its deviation, each (t,) [N m].

    Friction is the difference between sliding and standing still, excluding the torque transmitted to the
    link. Offset, ripple and rotor inertia cancel in this difference. Dependences on other quantities are
    evaluated at the middle of the position range, the nominal load there, and `ROOM_TEMPERATURE`.
    """
    gears = replace(fit.model, effects=tuple(e for e in fit.model.effects if not e.transmitted), stated={})
    names = [fit.base.parameters[column].name for column in fit.base.kept]
    identified = [names.index(name) for name in gears.names if name in names]
    columns = [place for place, name in enumerate(gears.names) if name in names]
    sliding = gears.regressor(_alone(fit.model, joint, velocity))
    standing = gears.regressor(_alone(fit.model, joint, np.zeros_like(velocity)))
    to_motor = fit.model.robot.to_motors[joint]
    rows = np.einsum("i,tip->tp", to_motor, (sliding - standing)[1::2, :, columns])
    covariance = fit.estimate.covariance[np.ix_(identified, identified)]
    variance = np.einsum("tp,pq,tq->t", rows, covariance, rows)
    return rows @ fit.estimate.values[identified], np.sqrt(np.maximum(variance, 0.0))


def _alone(model: Model, joint: int, velocity: np.ndarray) -> Motion:
    """Motion of 2 t samples in which one joint slides at velocities (t,), each after `APPROACH`."""
    limits = model.robot.limits
    middle = (np.maximum(limits.position_lower, -np.pi) + np.minimum(limits.position_upper, np.pi)) / 2
    still = np.zeros((2 * len(velocity), model.robot.dof))
    position, speed = still + middle, still.copy()
    speed[:, joint] = np.repeat(velocity, 2)
    position[::2] -= APPROACH * np.sign(speed[::2])
    time = np.arange(len(still)) * 1.0
    warm = np.full_like(still, ROOM_TEMPERATURE)
    at_rest = model.loaded(Motion.of(time, position, still, still, temperature=warm))
    return replace(at_rest, velocity=speed)
