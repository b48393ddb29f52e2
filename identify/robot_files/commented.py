"""A robot.toml with a comment above each key that gives its meaning and unit."""

import inspect
import re
import sys
import textwrap
from collections.abc import Iterator

from exidyn.quoting import hash_comment, one_line

from ..effects import Effect
from ..measurements import Measurement
from ..model import Model
from .robot_keys import KEYS, TITLES
from .robot_text import RIGID_BODY, model_text

Row = Effect | Measurement

WIDTH = 100
"""Maximum length of a comment line in characters."""
HEAD = (
    "Nominal model of one arm: its values before any identification. All values are in SI units and refer to "
    "the joint, behind the gear; lists have one number per joint, base to tip. All keys: docs/robot-toml.md."
)
ROWS = ("[[effect]]", "[[measurement]]")
"""Tables whose rows are effects or measurements, which have their own fields."""
FORMULA = re.compile(r"\s*:math:`[^`]*`,?")
ATTRIBUTE = re.compile(r"^(\w+): (.*(?:\n[ \t]+.*)*)", re.MULTILINE)


def commented_text(model: Model) -> str:
    """Text of `model_text` with a comment above each key; reading it gives the same model."""
    text = model_text(model)
    rigid_body = f'name = "{RIGID_BODY}"' in text  # a file needs this row only for its parameters
    effects = [effect for effect in model.effects if rigid_body or not effect.of_links]
    lines = _lines(text, model, iter([*effects, *model.measurements]))
    return "\n".join([*_comment(HEAD), "", *lines]) + "\n"


def _lines(text: str, model: Model, effects: Iterator[Row]) -> Iterator[str]:
    """Lines of a robot.toml, with comment lines between them."""
    table, seen, effect = "", set(), None
    for line in text.splitlines():
        if line.startswith("["):
            table = line
            effect = next(effects) if table in ROWS else None
            yield from _comment("" if table in seen else TITLES.get(table, ""))
            if effect is not None:  # the first line of the docstring of its module
                title = (sys.modules[type(effect).__module__].__doc__ or "").partition("\n")[0]
                yield from _comment(title.replace(" (the paper's section V.B)", ""))
            explained = table in seen and effect is None
            seen.add(table)
        elif line and (effect or table == "" or not explained):
            yield from _comment(_of_key(table, line.partition(" = ")[0], effect, model))
        yield line


def _of_key(table: str, key: str, effect: Row | None, model: Model) -> str:
    """Meaning of a key of a table."""
    if isinstance(effect, Effect) and key == "values":
        units: dict[str, list[str]] = {}
        for parameter in effect.parameters(model.robot):
            units.setdefault(parameter.unit, []).append(parameter.name)
        words = (f"{', '.join(names)} [{unit}]" for unit, names in units.items())
        return f"Nominal values of {'; '.join(words)}"
    described = _attributes(effect).get(key, "") if effect is not None else ""
    text = KEYS[table].get(key, "") or described
    return text[:1].upper() + text[1:]


def _attributes(effect: Row) -> dict[str, str]:
    """Descriptions of an effect's fields, from its docstring up to the first full stop or semicolon."""
    descriptions: dict[str, str] = {}
    for kind in reversed(type(effect).__mro__):
        text = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")[2]
        for name, words in ATTRIBUTE.findall(textwrap.dedent(text)):
            plain = FORMULA.sub("", " ".join(words.split()))
            descriptions[name] = re.split(r"[;.](?:\s|$)", plain)[0]
    return descriptions


def _comment(text: str) -> list[str]:
    lines = textwrap.wrap(one_line(text), WIDTH - len(hash_comment("")), break_long_words=False)
    return [hash_comment(line) for line in lines]
