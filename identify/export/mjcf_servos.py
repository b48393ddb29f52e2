"""Servos whose damping MuJoCo makes of the inertia, by `dampratio`: it stays as it was."""

from collections.abc import Iterator
from typing import Any

from ..robot_files.mjcf_names import name_of
from .mjcf_changes import DIGITS, Change, same
from .xml_text import Edits, Tag


def keep_damping(root: Tag, old: Any, new: Any, edits: Edits) -> Iterator[Change]:
    """Write the damping that servos had, where the file with its changes gives them another.

    Args:
        root: Of the file's text; servos of other files are left alone.
        old: What MuJoCo made of the file.
        new: What it makes of the file with its changes.
        edits: Where it is written.
    """
    tags = [tag for part in root.children if part.name == "actuator" for tag in part.children]
    for actuator in range(old.nu):
        kept, made = (-float(model.actuator_biasprm[actuator][2]) for model in (old, new))
        tag = _tag(tags, old, actuator)
        if tag is not None and not same(kept, made):
            edits.set(tag, dampratio=None, kv=f"{kept:.{DIGITS}g}")
            where = f"servo '{name_of(old, 'actuator', actuator)}', in place of dampratio"
            yield Change(where, "kv", "N m s/rad", made, kept, 0.0)


def _tag(tags: list[Tag], model: Any, actuator: int) -> Tag | None:
    """The tag of a position servo, by its name or its place among all; None for others."""
    name = name_of(model, "actuator", actuator)
    named = [tag for tag in tags if tag.attributes.get("name") == name]
    if not named and len(tags) == model.nu and "name" not in tags[actuator].attributes:
        named = [tags[actuator]]
    return named[0] if named and named[0].name == "position" else None
