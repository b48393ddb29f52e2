"""Schemas that check files before use: exidyn wrote them, but a person may have edited them.

A schema is a frozen `msgspec.Struct`. Its annotations are the types and ranges of single values; its
`__post_init__` checks that fields agree with each other, with the `check_` functions here, which raise a
`Disagreement` about the first wrong value; `forbid_unknown_fields` refuses unknown keys. An error is one line
with the file, the field, what was expected, and the value. Errors in TOML files are a `RobotError` and use
the terms of TOML.
"""

import re
from collections.abc import Callable, Collection, Mapping, Sequence, Sized
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

import msgspec
import numpy as np
from msgspec import Meta

from .errors import ExidynError, NotAFile, RobotError, UnknownKey

LARGEST = 1e100
"""Largest magnitude of a number: the product of three does not overflow, and no arm needs larger numbers."""
NEGATIVE = 1e-6
"""Largest magnitude of a negative eigenvalue of a correlation matrix, due to rounding and printing."""
SHOWN = 60
"""Maximum length of a wrong value in a message, in characters."""

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
"""A finite number of plausible magnitude."""
LARGEST_FLOAT = 1e150
"""Largest magnitude of a number in a result file, whose square does not overflow. Simulations that diverge
leave larger ones, which are written as null."""
if TYPE_CHECKING:
    Real = float
else:

    class Real(float):
        """Any number; null in a file is NaN."""


Size = Annotated[float, Meta(ge=0.0, le=LARGEST)]
"""A number of at least zero, such as a standard deviation or a root mean square."""
Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
SizeWritten = Size | Literal["inf", "nan"]
"""A size in fit.json, which holds numbers that are not finite as text."""
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
"""Name of a type in msgspec -> its name in messages about TOML."""


class Disagreement(ValueError):
    """Fields that do not agree; msgspec adds their place to the message."""


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
        ExidynError: The content is wrong; the message names the field, what is expected, and the value.
        UnknownKey: A key is unknown and `error` is a `RobotError`; the message lists the valid keys.
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
            unknown_key = UnknownKey(unknown[1], place, _keys(schema, path))
            raise (unknown_key if toml else error(str(unknown_key))) from None
        if missing:
            raise error(f"{place}: key '{missing[1]}' is missing") from None
        if of_table:
            raise error(f"{place}{' ' if toml and path else ': '}{text.replace('`', '')}") from None
        kind = "a key: " if match["key"] else ""
        if toml:
            text = re.sub("`[^`]*`", _of_toml, text.partition(", got")[0])
        text = text.replace("`", "")
        text = text[:1].lower() + text[1:]
        value = "" if match["key"] else _shown_at(table if written is None else written, path)
        raise error(f"{place}: {kind}{text}{value}") from None


def _place(path: str, toml: bool, of_table: bool) -> str:
    """Place in a file: for JSON the path from msgspec, for TOML the table in brackets and the key."""
    if not path or path.startswith("["):
        return path
    if not toml:
        return f": {path}"
    table, _, key = (path, "", "") if of_table else path.rpartition(".")
    return f": [{table}]{' ' if key else ''}{key}" if table else f": {key}"


def _of_toml(kind: re.Match[str]) -> str:
    words = [OF_TOML.get(word, word) for word in kind[0].strip("`").split(" ") if word != "|"]
    return " or ".join(words) if " | " in kind[0] else " ".join(words)


def _keys(schema: Any, path: str) -> list[str]:
    """Keys of the struct at a path from msgspec."""
    for step in STEP.finditer(path):
        if step["name"]:
            schema = next(f.type for f in _fields(schema) if f.encode_name == step["name"])
    return [field.encode_name for field in _fields(schema)]


def _fields(kind: Any) -> tuple[msgspec.structs.FieldInfo, ...]:
    """Fields of a struct, or of the struct inside an annotation such as a list of structs."""
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return msgspec.structs.fields(kind)
    return next((inner for part in get_args(kind) if (inner := _fields(part))), ())


def _shown_at(table: object, path: str) -> str:
    """Value at a path from msgspec, which omits the keys of mappings."""
    value = table
    for step in STEP.finditer(path):
        if step["any"]:
            return ""
        value = value[step["name"]] if isinstance(value, Mapping) else value[int(step["place"])]  # type: ignore[index]
    return f"; found {shown(value)}"


def shown(value: object) -> str:
    """Text of a value for a message, cut off if it is long."""
    if isinstance(value, list | dict) and len(value) > SHOWN:
        return f"{type(value).__name__} of {len(value)}"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**SHOWN else "a number of many digits"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def check(holds: bool, field: str, value: object, expected: str) -> None:
    """Refuse a field that does not agree with the others."""
    if not holds:
        raise Disagreement(f"{field}: expected {expected}; found {shown(value)}")


def check_length(values: Sized | None, field: str, length: int, description: str) -> None:
    """Refuse a list whose length differs from `length`; None, for a missing list, passes."""
    if values is not None and len(values) != length:
        raise Disagreement(f"{field}: expected {length} values, {description}; found {len(values)}")


def check_rows(rows: Sequence[Sized] | None, field: str, width: int, description: str) -> None:
    """Refuse a table with a row whose length differs from `width`."""
    for place, row in enumerate(rows or ()):
        check_length(row, f"{field}[{place}]", width, description)


def check_different(values: Sequence[Any], field: str) -> None:
    """Refuse a list with repeated values."""
    seen: set[Any] = set()
    for place, value in enumerate(values):
        check(value not in seen, f"{field}[{place}]", value, "a value not listed before")
        seen.add(value)


def check_known(values: Sequence[Any], field: str, known: Collection[Any], expected: str) -> None:
    """Refuse a list with unknown values."""
    for place, value in enumerate(values):
        check(value in known, f"{field}[{place}]", value, expected)


def check_joints(numbers: Sequence[int], field: str, count: int) -> None:
    """Refuse joint numbers that are repeated, or not between 1 and the number of joints, `count`."""
    check_known(numbers, field, range(1, count + 1), f"the number of a joint, from 1 to {count}")
    check_different(numbers, field)


def check_covariance(rows: Sequence[Sequence[float]], field: str) -> None:
    """Refuse a matrix (n, n) that is not a covariance."""
    matrix = np.array(rows, float).reshape(len(rows), len(rows))
    variance = np.diag(matrix)
    for k in np.flatnonzero(variance < 0.0)[:1]:
        check(False, f"{field}[{k}][{k}]", float(variance[k]), "a variance of zero or above")
    std = np.sqrt(variance)
    scale = np.outer(std, std)
    for k, j in np.argwhere(np.abs(matrix - matrix.T) > NEGATIVE * scale)[:1]:
        check(False, f"{field}[{k}][{j}]", rows[k][j], f"{rows[j][k]}, which is {field}[{j}][{k}]")
    for k, j in np.argwhere(np.abs(matrix) > (1.0 + NEGATIVE) * scale)[:1]:
        limit = f"at most {scale[k, j]:.3g} in size, the product of both standard deviations"
        check(False, f"{field}[{k}][{j}]", rows[k][j], limit)
    known = std > 0.0
    correlation = matrix[np.ix_(known, known)] / std[known] / std[known][:, None]
    least = float(np.min(np.linalg.eigvalsh(correlation), initial=0.0))
    allowed = -NEGATIVE * max(len(correlation), 1)
    check(least >= allowed, field, least, "correlations without a negative eigenvalue")
