"""Bodies, joints and actuators of a compiled MJCF in its text."""

from collections.abc import Iterator
from typing import Any

from ..errors import RobotError
from ..robot_files.mjcf_names import actuators, name_of
from .xml_text import Tag


class Elements:
    """Start tags of bodies, joints and actuators, by their indices in the compiled model."""

    def __init__(self, root: Tag, model: Any, where: str) -> None:
        self.root, self._model, self._where = root, model, where
        bodies = [tag for world in root.children if world.name == "worldbody" for tag in _bodies(world)]
        joints = [tag for body in bodies for tag in _joints(body)]
        actuators = [tag for part in root.children if part.name == "actuator" for tag in part.children]
        self._tags = {"body": bodies, "joint": joints, "actuator": actuators}

    def body(self, body: int) -> Tag:
        """The tag of a body; 0 is the world and has none."""
        return self._tag("body", body, body - 1)

    def joint(self, joint: int) -> Tag:
        """The tag of a joint."""
        return self._tag("joint", joint, joint)

    def actuator(self, actuator: int) -> Tag:
        """The tag of an actuator."""
        return self._tag("actuator", actuator, actuator)

    def position_servo(self, actuator: int) -> Tag | None:
        """The tag of an actuator with a position gain; None for others, and for those of included files."""
        tag = self._found("actuator", actuator, actuator)
        return tag if tag and tag.name in ("position", "intvelocity", "general") else None

    def _tag(self, kind: str, index: int, place: int) -> Tag:
        """The tag of an element; raises `RobotError` if it is in an included file or replicated."""
        if tag := self._found(kind, index, place):
            return tag
        name = name_of(self._model, kind, index)
        raise RobotError(
            f"{self._where}: {kind} '{name}' is not in the text of this file, but in an included file, or "
            "created by replicate or attach. Give the file that contains it"
        )

    def _found(self, kind: str, index: int, place: int) -> Tag | None:
        """The tag with an element's name, or at its place if that tag has no name and none is elsewhere."""
        model, tags = self._model, self._tags[kind]
        if named := [tag for tag in tags if tag.attributes.get("name") == name_of(model, kind, index)]:
            return named[0]
        counts = {"body": model.nbody - 1, "joint": model.njnt, "actuator": len(actuators(model))}
        complete = len(tags) == counts[kind]
        return tags[place] if complete and "name" not in tags[place].attributes else None

    @property
    def degrees(self) -> bool:
        """Whether angles are in degrees, MuJoCo's default."""
        units = [tag.attributes["angle"] for tag in self.root.children if "angle" in tag.attributes]
        return not units or units[-1] == "degree"


def _bodies(tag: Tag) -> Iterator[Tag]:
    """Bodies inside a tag, in MuJoCo's order."""
    for child in tag.children:
        if child.name == "body":
            yield child
        if child.name in ("body", "frame"):
            yield from _bodies(child)


def _joints(tag: Tag) -> Iterator[Tag]:
    """Joints that belong directly to a body."""
    for child in tag.children:
        if child.name in ("joint", "freejoint"):
            yield child
        elif child.name == "frame":
            yield from _joints(child)
