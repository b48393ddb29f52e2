"""A URDF arm of boxes, capsules, cylinders and spheres: turning, sliding, branched, with fixed links."""

from pathlib import Path

from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.robot_file import read_model

LINK = '<link name="{name}"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" \
izz="0.1"/></inertial>{bodies}</link>'
BODY = '<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}</geometry></collision>'
JOINT = '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>\
<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>\
<limit lower="{lower}" upper="{upper}" velocity="3" effort="100"/></joint>'


def body(shape, xyz="0 0 0", rpy="0 0 0"):
    return BODY.format(shape=f"<{shape}/>", xyz=xyz, rpy=rpy)


def link(name, *bodies):
    return LINK.format(name=name, bodies="".join(bodies))


def joint(name, parent, child, xyz, axis="0 0 1", kind="revolute", rpy="0 0 0", lower=-3, upper=3):
    return JOINT.format(
        name=name,
        parent=parent,
        child=child,
        xyz=xyz,
        axis=axis,
        kind=kind,
        rpy=rpy,
        lower=lower,
        upper=upper,
    )


PARTS = (
    link("world"),
    link("base", body('box size="0.3 0.2 0.2"', "0 0 0.1")),
    link("shoulder", body('sphere radius="0.09"')),
    link("upper", body('capsule radius="0.05" length="0.4"', "0.02 0 0.25", "0 0.1 0")),
    link("fore", body('cylinder radius="0.06" length="0.3"', "0 0 0.2")),
    link("slider", body('capsule radius="0.04" length="0.2"', "0 0 0.1")),
    link("tool", body('sphere radius="0.05"', "0 0 0.1"), body('sphere radius="0.03"', "0.1 0 0.1")),
    link("mast", body('sphere radius="0.1"', "0 0 0.5")),
    joint("stand", "world", "base", "0 0 0.5", kind="fixed", rpy="0 0 0.3"),
    joint("pan", "base", "shoulder", "0 0 0.32", kind="continuous"),
    joint("lift", "shoulder", "upper", "0 0.03 0.05", "0 1 0.2", rpy="0.2 0 0"),
    joint("elbow", "upper", "fore", "0 0.02 0.55", "0 2 0"),
    joint("slide", "fore", "slider", "0.01 0 0.4", "0.1 0 1", kind="prismatic", lower=-0.2, upper=0.3),
    joint("flange_fixed", "slider", "tool", "0 0 0.25", kind="fixed", rpy="0 0.5 0"),
    joint("mast_turn", "base", "mast", "0.35 0 0", "1 0 0.2", lower=-1.5, upper=1.5),
)


def write(folder, parts=PARTS, name="small.urdf"):
    path = Path(folder) / name
    path.write_text(f'<robot name="small">{"".join(parts)}</robot>')
    return path


def small_arm(folder):
    """Its robot and its geometry."""
    path = write(folder)
    return read_model(path).robot, read_geometry(path)
