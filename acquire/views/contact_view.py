"""View of contact: external torques with their thresholds, and the arm with the force on its flange."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.contact.contact import Contact
from exidyn.identification.model import Model

from .parts import (
    ARM,
    COLORS,
    FAINT,
    FRAMES,
    RED,
    TIMELINE,
    Arm,
    arm_view,
    base_frame,
    entity,
    event_list,
    log_event,
    log_lines,
    plot,
    reach,
    screen,
)
from .viewers import View

EXTERNAL, FORCE, EVENTS = "external torque", "force", "contacts"
"""Parts of entity paths: torques by joint, the arrow at the flange, and the list of contacts."""
LONGEST = 0.5
"""Length of the arrow of the largest force, over the reach of the arm [-]."""


def contact_view(result: Contact, model: Model, unit: str) -> View:
    """A view of external torques along a run; `unit` is that of the torques."""

    def log(stream: rr.RecordingStream) -> None:
        _log_torques(stream, result, model)
        known = np.flatnonzero(np.all(np.isfinite(result.estimates.position), axis=1))
        rows = known[:: _stride(result.estimates.time[known])]
        Arm(stream, model).move(result.estimates.time[rows], result.estimates.position[rows])
        _log_force(stream, result, model, rows)
        for alarm in result.alarms:
            joint = model.robot.joints[alarm.joint]
            log_event(stream, [EVENTS], alarm.start, "contact", f"{joint}, until {alarm.end:.2f} s")

    plots = [
        plot(entity(EXTERNAL, joint), f"{joint}: external torque [{unit}]", legend=not place)
        for place, joint in enumerate(model.robot.joints)
    ]
    arm = arm_view(model, title="arm, and force on the flange")
    beside = rrb.Vertical(arm, event_list(EVENTS), row_shares=[3, 1]) if result.alarms else arm
    return View("contact", log, screen(rrb.Horizontal(rrb.Grid(*plots, grid_columns=2), beside)))


def _stride(time: np.ndarray) -> int:
    """Number of samples from one frame of the arm to the next."""
    return max(1, round(len(time) / (FRAMES * max(time[-1] - time[0], 1e-9)))) if len(time) else 1


def _log_torques(stream: rr.RecordingStream, result: Contact, model: Model) -> None:
    """Torque of each joint, between the two lines beyond which it counts as contact."""
    time, torque = result.estimates.time, result.estimates.torque
    limits = None if result.threshold is None else result.threshold.torque(result.estimates)
    for joint, name in enumerate(model.robot.joints):
        path = entity(EXTERNAL, name, "torque")
        log_lines(stream, path, ["external torque"], [COLORS[0]], time, torque[:, joint])
        if limits is not None:
            band = np.stack([limits[:, joint], -limits[:, joint]], axis=1)
            colors = [(*RED, FAINT)] * 2
            log_lines(
                stream, entity(EXTERNAL, name, "threshold"), ["threshold", "- threshold"], colors, time, band
            )


def _log_force(stream: rr.RecordingStream, result: Contact, model: Model, rows: np.ndarray) -> None:
    """An arrow at the flange; the largest force has the length `LONGEST`."""
    force = result.wrench[:, :3]
    rows = rows[np.all(np.isfinite(force[rows]), axis=1)]
    if not len(rows):
        return
    robot, data = model.robot, model.robot.kinematics.createData()
    position = result.estimates.position
    origins = np.array([flange_position(robot.kinematics, robot.flange, position[row], data) for row in rows])
    largest = float(np.max(np.linalg.norm(force[rows], axis=1))) or 1.0
    path = entity(ARM, FORCE)
    stream.log(path, rr.CoordinateFrame(base_frame(model)), static=True)
    stream.log(path, rr.Arrows3D.from_fields(colors=RED), static=True)
    vectors = force[rows] * LONGEST * reach(model) / largest
    columns = rr.Arrows3D.columns(origins=origins, vectors=vectors)
    index = rr.TimeColumn(TIMELINE, duration=result.estimates.time[rows])
    stream.send_columns(path, indexes=[index], columns=columns)
