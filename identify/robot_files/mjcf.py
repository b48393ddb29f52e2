"""Robots in MJCF, the format of MuJoCo, which compiles them: kinematics, inertias, torques, limits."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.robot import Held
from ..errors import BrokenTree, MissingPackage
from ..file_names import read_failure
from ..notebook import optional
from .folders import require_mjcf_files
from .kinematics import Kinematics, Part, add_joint, body_doubts, check_center, joint_model, named_flange
from .mjcf_dcmotors import dc_motors, gear_ratios, motor_doubts
from .mjcf_drives import effect_rows, limits_of, motor_coupling, torque_limits
from .mjcf_elements import HOLD, disabled, joint_equalities, joint_name, name_of, single, turns
from .mjcf_held import held_placement, held_positions, joint_motion, placement_of
from .mjcf_refusals import check_mjcf, gravity_share
from .urdf import FLANGES, TOOLS

SITES = (*FLANGES, *TOOLS, "attachment_site", "attachment")
"""Names (or ends of names) of sites that carry payloads, the most likely first."""


def compile_mjcf(source: Path | str, folder: str = "") -> Any:
    """MuJoCo's compiled model of a file, or of a text whose files lie in `folder`.

    Raises `BrokenTree` if MuJoCo cannot compile it, and `RobotError` if it names a file outside its folder.
    """
    mujoco = optional("mujoco", "an MJCF", "mujoco")
    if not hasattr(mujoco, "MjSpec"):
        raise MissingPackage(f'MuJoCo {mujoco.__version__} has no MjSpec: pip install "mujoco>=3.3"')
    where = "MJCF" if folder else str(source)
    try:
        text = str(source).encode() if folder else Path(source).read_bytes()
    except OSError as error:
        raise BrokenTree(f"{source}: cannot be read: {read_failure(Path(source), error)}") from error
    included = require_mjcf_files(text, Path(folder) / "MJCF" if folder else Path(source))
    try:
        if not folder:
            return mujoco.MjSpec.from_file(str(source)).compile()
        spec = mujoco.MjSpec.from_string(str(source), include=included)
        spec.modelfiledir = folder
        return spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise BrokenTree(f"{where}: MuJoCo: {error}") from error


def movable_mjcf_joints(path: Path) -> tuple[list[str], list[str]]:
    """Joints of an MJCF: joints that a model can have, and joints that have to be held."""
    model = compile_mjcf(path)
    bound = {follower for _, follower, leader in joint_equalities(model) if leader >= 0}
    bound |= {joint for joint in range(model.njnt) if not single(model, joint)}
    free = [joint_name(model, joint) for joint in range(model.njnt) if joint not in bound]
    return free, [joint_name(model, joint) for joint in sorted(bound)]


def mjcf_kinematics(
    model: Any, where: str, moving: Collection[str] | None = None, held: Held = MappingProxyType({})
) -> Kinematics:
    """Kinematics of a compiled MJCF; `moving` and `held` are those of `read_kinematics`.

    Raises `BrokenTree` if it is not a tree of joints with one degree of freedom, and `RobotError` for a force
    that no model can represent.
    """
    still = held_positions(model, moving, held, where)
    joints = [joint for joint in range(model.njnt) if joint not in still]
    if not joints:
        raise BrokenTree(f"{where}: no joint moves; at least one must be a hinge or slide")
    for joint in joints:
        if not single(model, joint):
            raise BrokenTree(
                f"{where}: joint '{joint_name(model, joint)}' is free or a ball; a model has hinges and "
                "slides. " + HOLD
            )
    tree, parts = _tree(model, still, where)
    tree.name = bytes(model.names).partition(b"\0")[0].decode(errors="replace") or "robot"
    check_mjcf(model, [part.joint for part in parts], joints, where)
    share = gravity_share(model, [part.joint for part in parts], joints, where)
    gravity = np.zeros(3) if disabled(model, "GRAVITY") else share * np.array(model.opt.gravity)
    tree.gravity = pin.Motion(gravity, np.zeros(3))
    doubts = [*body_doubts(tree), *motor_doubts(model, joints, where)]
    if share < 1.0:
        doubts.append(
            f"{where}: gravcomp leaves {share:g} of gravity. If the motors of the recorded arm carry its "
            "weight, state gravity in a robot.toml"
        )
    return Kinematics(
        tree,
        limits_of(model, joints, torque_limits(model, joints)),
        *_flange(model, parts, tree),
        doubts=tuple(doubts),
        effects=effect_rows(model, joints),
        coupling=motor_coupling(model, joints, where),
        held=dict(held),
        gear_ratio=gear_ratios(dc_motors(model, joints), joints),
    )


def body_parts(model: Any, moving: Collection[str] | None, held: Held, where: str) -> list[Part]:
    """Place of each body of a compiled MJCF in the tree of joints that `mjcf_kinematics` makes."""
    return _tree(model, held_positions(model, moving, held, where), where)[1]


def _tree(model: Any, still: Mapping[int, np.ndarray], where: str) -> tuple[pin.Model, list[Part]]:
    """Pinocchio's model of the joints that are not held, and the place of each body in it."""
    tree, parts = pin.Model(), [Part(0, pin.SE3.Identity())]
    for body in range(1, model.nbody):
        parts.append(_add_body(tree, model, body, parts[model.body_parentid[body]], still, where))
    for body, part in enumerate(parts):
        inertia = own_inertia(model, body)
        check_center(inertia.mass, inertia.lever, f"{where}: body '{name_of(model, 'body', body)}'")
        if part.joint and inertia.mass:
            tree.inertias[part.joint] = tree.inertias[part.joint] + part.placement.act(inertia)
    return tree, parts


def _add_body(
    tree: pin.Model, model: Any, body: int, parent: Part, still: Mapping[int, np.ndarray], where: str
) -> Part:
    """Add the joints of a body in series; MuJoCo turns each joint about its anchor in the body."""
    index, place = parent.joint, parent.placement * placement_of(model.body_pos[body], model.body_quat[body])
    start, link = int(model.body_jntadr[body]), name_of(model, "body", body)
    joints = range(start, start + int(model.body_jntnum[body]))
    for joint in joints:
        if joint in still:
            place = held_placement(model, joint, still[joint], place)
            continue
        anchor, axis = pin.SE3(np.eye(3), model.jnt_pos[joint].copy()), model.jnt_axis[joint].copy()
        hinge, name = turns(model, joint), joint_name(model, joint)
        reference = float(model.qpos0[model.jnt_qposadr[joint]])
        frame = place * anchor * joint_motion(axis, -reference, hinge)
        last = joint == joints[-1]
        kind = "revolute" if hinge else "prismatic"
        try:
            index = add_joint(
                tree, index, joint_model(kind, axis), frame, name, link if last else f"{link}_{name}"
            )
        except BrokenTree as error:
            raise BrokenTree(f"{where}: {error}") from error
        place = anchor.inverse()
    return Part(index, place)


def own_inertia(model: Any, body: int) -> pin.Inertia:
    """Inertia of a body in its own frame."""
    principal = placement_of(model.body_ipos[body], model.body_iquat[body])
    about = principal.rotation @ np.diag(model.body_inertia[body]) @ principal.rotation.T
    return pin.Inertia(float(model.body_mass[body]), principal.translation, (about + about.T) / 2)


def _flange(model: Any, parts: Sequence[Part], tree: pin.Model) -> tuple[pin.SE3, str]:
    """Placement, in the last joint's frame, of the site or body whose name is that of a flange; its name."""
    last = tree.njoints - 1
    candidates = {
        name_of(model, "site", site): parts[model.site_bodyid[site]].placement
        * placement_of(model.site_pos[site], model.site_quat[site])
        for site in range(model.nsite)
        if parts[model.site_bodyid[site]].joint == last
    }
    candidates |= {
        name_of(model, "body", body): part.placement for body, part in enumerate(parts) if part.joint == last
    }
    return named_flange(tree, candidates, SITES)
