"""Schemas: files that exidyn wrote and that a person may have edited are checked before anything uses them.

A schema is a frozen `msgspec.Struct`. Its annotations are the types and ranges of single values; its
`__post_init__` checks what has to agree between fields, by the `check_` functions here; with
`forbid_unknown_fields` a key that it lacks is refused. What is wrong is told in one line: the file, the
field, what was expected, and the value; of TOML, whose errors are a `RobotError`, in its own words.
"""

import re
from collections.abc import Callable, Collection, Mapping, Sequence, Sized
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

import msgspec
import numpy as np
from msgspec import Meta

from .errors import ExidynError, NotAFile, RobotError, UnknownKey

LARGEST = 1e100
"""Size of a number, at most: the product of three is still a number, and nothing of an arm comes near it."""
NEGATIVE = 1e-6
"""Negative eigenvalue of a correlation matrix, at most: what rounding and printing leave of zero."""
SHOWN = 60
"""Characters of a wrong value in a message."""

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
"""Finite."""
LARGEST_FLOAT = 1.7e308
"""Size of a number that a simulation may leave when it diverges, at most."""
if TYPE_CHECKING:
    Real = float
else:

    class Real(float):
        """Any number; null in a file is NaN."""


Positive = Annotated[float, Meta(gt=0.0, le=LARGEST)]
Size = Annotated[float, Meta(ge=0.0, le=LARGEST)]
"""Zero or above, as a deviation or a root mean square is."""
Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
JointNumber = Annotated[int, Meta(ge=1, le=2**53)]
"""From 1."""
Written = Number | Literal["inf", "-inf", "nan"]
"""A number of which fit.json writes what is not finite as text."""
SizeWritten = Size | Literal["inf", "nan"]
NumberOrNull = Number | None
SizeOrNull = Size | None
Name = Annotated[str, Meta(min_length=1, max_length=1000)]
EffectName = Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]{0,99}$")]

T = TypeVar("T")
PATH = re.compile(r"^(?P<text>.*?)(?: - at `(?P<key>key in )?\$(?P<path>.*)`)?$", re.DOTALL)
STEP = re.compile(r"\.(?P<name>[^.\[]+)|\[(?P<place>\d+)\]|(?P<any>\[\.\.\.\])")
MISSING = re.compile(r"^Object missing required field `(.*)`$")
UNKNOWN = re.compile(r"^Object contains unknown field `(.*)`$")
OF_TOML = {
    "str": "text in quotes", "float": "number", "int": "whole number", "bool": "true or false",
    "object": "table", "array": "list",
}  # fmt: skip
"""What msgspec calls a type -> what it is called where people write TOML."""


class Disagreement(ValueError):
    """Fields that do not agree; msgspec puts before it where they are."""


def checked(
    table: object,
    schema: type[T],
    where: str,
    error: type[ExidynError] = NotAFile,
    read: Callable[[type, Any], Any] | None = None,
    written: object = None,
) -> T:
    """The content of a file, parsed JSON or TOML, as its schema.

    Args:
        table: Parsed content.
        schema: Struct or dataclass that it has to be.
        where: What a message calls the file.
        error: Type of the error.
        read: Makes values of types that msgspec does not know.
        written: The table as the file has it, for the value in a message, where the table was changed.

    Raises:
        ExidynError: Of that type; the message names the field, what is expected, and the value.
        UnknownKey: In place of a `RobotError`, with the keys that are valid.
    """
    try:
        return msgspec.convert(table, schema, dec_hook=read)
    except msgspec.ValidationError as problem:
        match = PATH.match(str(problem))
        assert match is not None
        text, path, toml = match["text"], match["path"] or "", issubclass(error, RobotError)
        missing, unknown = MISSING.match(text), UNKNOWN.match(text)
        by_check = problem.__cause__ is not None  # an error that a `check_` function raised
        of_table = bool(missing or unknown or by_check)
        place = f"{where}{_place(path.lstrip('.'), toml, of_table)}"
        if unknown:
            kept = UnknownKey(unknown[1], place, _keys(schema, path))
            raise (kept if toml else error(str(kept))) from None
        if missing:
            raise error(f"{place}: key '{missing[1]}' is missing") from None
        if of_table:
            raise error(f"{place}{' ' if toml and path else ': '}{text.replace('`', '')}") from None
        kind = "a key: " if match["key"] else "" if path else "the whole: "
        if toml:
            text = re.sub("`[^`]*`", _of_toml, text.partition(", got")[0])
        text = text.replace("`", "")
        text = text[:1].lower() + text[1:]
        found = "" if match["key"] else _shown_at(table if written is None else written, path)
        raise error(f"{place}: {kind}{text}{found}") from None


def _place(path: str, toml: bool, of_table: bool) -> str:
    """Where in a file: of JSON as msgspec has it, of TOML the table in brackets and the key behind it."""
    if not toml or not path:
        return f": {path}" if path else ""
    table, _, key = (path, "", "") if of_table else path.rpartition(".")
    return f": [{table}]{' ' if key else ''}{key}" if table else f": {key}"


def _of_toml(kind: re.Match[str]) -> str:
    words = [OF_TOML.get(word, word) for word in kind[0].strip("`").split(" ") if word != "|"]
    return " or ".join(words) if " | " in kind[0] else " ".join(words)


def _keys(schema: Any, path: str) -> list[str]:
    """Keys of the struct at a path of msgspec."""
    for step in STEP.finditer(path):
        if step["name"]:
            schema = next(f.type for f in _fields(schema) if f.encode_name == step["name"])
    return [field.encode_name for field in _fields(schema)]


def _fields(kind: Any) -> tuple[msgspec.structs.FieldInfo, ...]:
    """Fields of a struct, or of the one inside an annotation such as a list of it."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return msgspec.structs.fields(kind)
    return next((found for part in get_args(kind) if (found := _fields(part))), ())


def _shown_at(table: object, path: str) -> str:
    """The value at a path of msgspec, which does not tell the names of tables' entries."""
    value = table
    for step in STEP.finditer(path):
        if step["any"]:
            return ""
        value = value[step["name"]] if isinstance(value, Mapping) else value[int(step["place"])]  # type: ignore[index]
    return f"; found {shown(value)}"


def shown(value: object) -> str:
    """A value in a message, cut off where it is long."""
    if isinstance(value, list | dict) and len(value) > SHOWN:
        return f"{type(value).__name__} of {len(value)}"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**SHOWN else "a number of many digits"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def check(holds: bool, field: str, value: object, expected: str) -> None:
    """Refuse a field that does not agree with the others.

    Raises:
        Disagreement: It does not hold.
    """
    if not holds:
        raise Disagreement(f"{_small(field)}: expected {expected}; found {shown(value)}")


def check_length(values: Sized | None, field: str, length: int, of: str) -> None:
    """Refuse a list of another length; one that is not there is not checked.

    Raises:
        Disagreement: With the field and both lengths.
    """
    if values is not None and len(values) != length:
        raise Disagreement(f"{_small(field)}: expected {length} values, {of}; found {len(values)}")


def check_rows(rows: Sequence[Sized] | None, field: str, width: int, of: str) -> None:
    """Refuse a table of which a row has another length.

    Raises:
        Disagreement: With the first such row.
    """
    for place, row in enumerate(rows or ()):
        check_length(row, f"{field}[{place}]", width, of)


def check_different(values: Sequence[Any], field: str) -> None:
    """Refuse a list that has something twice.

    Raises:
        Disagreement: With the first that was there before.
    """
    seen: set[Any] = set()
    for place, value in enumerate(values):
        check(value not in seen, f"{field}[{place}]", value, "what is not in the list before")
        seen.add(value)


def check_known(values: Sequence[Any], field: str, known: Collection[Any], expected: str) -> None:
    """Refuse a list that has something unknown.

    Raises:
        Disagreement: With the first.
    """
    for place, value in enumerate(values):
        check(value in known, f"{field}[{place}]", value, expected)


def check_joints(numbers: Sequence[int], field: str, count: int) -> None:
    """Refuse numbers of joints, from 1, that an arm of so many joints does not have, or has there twice.

    Raises:
        Disagreement: With the first.
    """
    check_known(numbers, field, range(1, count + 1), f"the number of a joint, from 1 to {count}")
    check_different(numbers, field)


def check_covariance(rows: Sequence[Sequence[float]], field: str) -> None:
    """Refuse a matrix (n, n) that is no covariance.

    Raises:
        Disagreement: A variance below zero, asymmetry, a correlation beyond one, an eigenvalue below zero.
    """
    matrix = np.array(rows, float).reshape(len(rows), len(rows))
    variance = np.diag(matrix)
    for k in np.flatnonzero(variance < 0.0)[:1]:
        check(False, f"{field}[{k}][{k}]", float(variance[k]), "a variance of zero or above")
    std = np.sqrt(variance)
    scale = np.outer(std, std)
    for k, j in np.argwhere(np.abs(matrix - matrix.T) > NEGATIVE * scale)[:1]:
        check(False, f"{field}[{k}][{j}]", rows[k][j], f"{rows[j][k]}, which is {field}[{j}][{k}]")
    for k, j in np.argwhere(np.abs(matrix) > (1.0 + NEGATIVE) * scale)[:1]:
        limit = f"at most {scale[k, j]:.3g} in size, the product of both deviations"
        check(False, f"{field}[{k}][{j}]", rows[k][j], limit)
    known = std > 0.0
    correlation = matrix[np.ix_(known, known)] / std[known] / std[known][:, None]
    least = float(np.min(np.linalg.eigvalsh(correlation), initial=0.0))
    allowed = -NEGATIVE * max(len(correlation), 1)
    check(least >= allowed, field, least, "correlations without a negative eigenvalue")


def _small(field: str) -> str:
    """Messages of checks begin in lower case, by which they are told from those of msgspec."""
    return field if field[:1].islower() else f"field {field}"
