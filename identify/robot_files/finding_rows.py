"""Findings in the robot file that a diagnosis writes: what was found, and whether the model holds it."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from .toml_fields import block, boolean, check_keys, number, string, strings, tables

KEY = "finding"
KEYS = ("effect", "joints", "probability", "in_model")


class FindingRow(NamedTuple):
    """One finding.

    Attributes:
        effect: Name in the vocabulary.
        joints: Names of the joints on which it acts; empty for the whole arm.
        probability: Probability that the missing physics is this effect.
        in_model: Whether the model of the file holds it.
    """

    effect: str
    joints: tuple[str, ...]
    probability: float
    in_model: bool


def findings_text(rows: Sequence[FindingRow]) -> str:
    """A table [[finding]] for each."""
    return "\n".join(block(f"[[{KEY}]]", row._asdict()) + "\n" for row in rows)


def parse_findings(table: dict[str, Any]) -> list[FindingRow]:
    """The findings of a parsed robot.toml; none in a file that no diagnosis wrote.

    Raises:
        RobotError: A row has a key that there is not, or a value of another type.
    """
    rows = []
    for place, row in enumerate(tables(table[KEY], KEY) if KEY in table else ()):
        where = f"[[{KEY}]] {place + 1}"
        check_keys(row, KEYS, where)
        rows.append(
            FindingRow(
                string(row.get("effect"), f"{where} effect"),
                tuple(strings(row.get("joints"), f"{where} joints")),
                number(row.get("probability"), f"{where} probability", 0.0),
                boolean(row.get("in_model"), f"{where} in_model"),
            )
        )
    return rows
