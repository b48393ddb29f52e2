"""Names and kinds of what is in a compiled MJCF."""

from typing import Any

from ..notebook import optional

HOLD = "Hold joints still in a robot.toml: mjcf = ..., joints = [those that move]"
OBJECTS = {
    "joint": "mjOBJ_JOINT",
    "body": "mjOBJ_BODY",
    "site": "mjOBJ_SITE",
    "tendon": "mjOBJ_TENDON",
    "actuator": "mjOBJ_ACTUATOR",
    "equality": "mjOBJ_EQUALITY",
}


def enum_of(kind: str, name: str) -> int:
    """A number of MuJoCo's, such as `enum_of("mjtJoint", "mjJNT_HINGE")`."""
    return int(getattr(getattr(optional("mujoco", "an MJCF", "mujoco"), kind), name))


def name_of(model: Any, kind: str, index: int) -> str:
    """Name of a thing, or its kind and number from 1 on where the file gives none."""
    mujoco = optional("mujoco", "an MJCF", "mujoco")
    named = mujoco.mj_id2name(model, getattr(mujoco.mjtObj, OBJECTS[kind]), index)
    return str(named or f"{kind}{index + 1}")


def joint_name(model: Any, joint: int) -> str:
    """Name of a joint."""
    return name_of(model, "joint", joint)


def turns(model: Any, joint: int) -> bool:
    """Whether a joint is a hinge."""
    return bool(model.jnt_type[joint] == enum_of("mjtJoint", "mjJNT_HINGE"))


def single(model: Any, joint: int) -> bool:
    """Whether a joint has one degree of freedom."""
    return turns(model, joint) or bool(model.jnt_type[joint] == enum_of("mjtJoint", "mjJNT_SLIDE"))


def joint_equalities(model: Any) -> list[tuple[int, int, int]]:
    """Equalities of joints that act: their number, the joint that follows, the one it follows or -1."""
    kind = enum_of("mjtEq", "mjEQ_JOINT")
    every = zip(model.eq_type, model.eq_active0, model.eq_obj1id, model.eq_obj2id, strict=True)
    return [
        (e, int(one), int(other))
        for e, (type_, active, one, other) in enumerate(every)
        if type_ == kind and active
    ]


def following_joints(model: Any) -> set[int]:
    """Joints that an equality makes follow another."""
    return {one for _, one, other in joint_equalities(model) if other >= 0}


def locked_joints(model: Any) -> dict[int, float]:
    """Joints that an equality locks, and how far from their reference [rad, m]."""
    return {one: float(model.eq_data[e][0]) for e, one, other in joint_equalities(model) if other < 0}
