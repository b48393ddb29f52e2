"""Measured and predicted torque of a run, drawn with matplotlib for a notebook."""

from typing import TYPE_CHECKING, Any

from ..arm.robot import Robot
from ..notebook import optional

if TYPE_CHECKING:
    from .fit import Agreement

HEIGHT, WIDTH = 1.4, 9.0
"""Of one joint, and of all [inch]."""


def figure(run: "Agreement", robot: Robot) -> Any:
    """One axis for each joint, over time [s].

    Raises:
        MissingPackage: matplotlib is not installed.
    """
    pyplot = optional("matplotlib.pyplot", "a plot")
    size = (WIDTH, HEIGHT * robot.dof + 0.9)
    found, grid = pyplot.subplots(robot.dof, sharex=True, squeeze=False, figsize=size, layout="constrained")
    axes = grid[:, 0]
    for joint, (axis, unit) in enumerate(zip(axes, robot.units("N m"), strict=True)):
        axis.plot(run.time, run.measured[:, joint], color="0.6", label="measured")
        axis.plot(run.time, run.predicted[:, joint], linewidth=1.0, label="predicted")
        axis.plot(run.time, run.residual[:, joint], linewidth=0.8, label="residual")
        axis.set_ylabel(f"{robot.joints[joint]} [{unit}]")
    found.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3)
    axes[0].set_title(run.run)
    axes[-1].set_xlabel("time [s]")
    pyplot.close(found)  # a notebook shows what a cell gives, and all figures that are open as well
    return found
