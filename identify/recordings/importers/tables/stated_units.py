"""Units in the names of columns: `q1 [deg]`, `i1_mA`, `tau1 (Nm)`, `time_ms`."""

import re

from ...units import SPELLINGS, UNITS, is_travel, unit_named

BRACKETED = re.compile(r"(.*?)[\s_]*(?:in\s+)?[\[(<{]\s*([^\[\](){}<>]+?)\s*[\])>}]\s*", re.DOTALL)
_WORDS = {name for names in SPELLINGS.values() for name in names.split()} - {"c", "min-1"} | {"nm"}
SUFFIXES = sorted(
    {*UNITS, *_WORDS, "Nm", "mNm", "Nmm", "C", "Deg", "Rad", "NM", "MS", "RPM"}, key=len, reverse=True
)
"""Units behind an underscore, a space or the like; `A` but not `a`, since `tau_a` belongs to a joint a."""
SUFFIXED = re.compile(rf"(.+?)(?:[\s_./,:-]+|\s+in\s+)({'|'.join(map(re.escape, SUFFIXES))})\s*")


def stated_unit(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit; "" if there is none."""
    for pattern in (BRACKETED, SUFFIXED):
        match = pattern.fullmatch(name)
        if match and match[1].strip() and is_unit(match[2]):
            return match[1].strip(), match[2]
    return name, ""


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any signal."""
    return unit_named(text) is not None or is_travel(text)


def is_unit_row(cells: list[str]) -> bool:
    """Whether a row below the names states units: at least two, and mostly units and placeholders."""
    stated = [cell for cell in cells if is_unit(cell)]
    others = [cell for cell in cells if cell.strip("[]()-– ") and not is_unit(cell)]
    return bool(stated) and len(stated) >= min(2, len(cells)) and len(others) <= len(stated)
