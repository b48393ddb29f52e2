"""Words for signals and units in the names of columns: `q1 [deg]`, `i1_mA`, `tau1 (Nm)`, `time_ms`."""

import re

from ..units import SPELLINGS, UNITS, is_travel, unit_named

WORDS: dict[str, frozenset[str]] = {
    "temperature": frozenset("temp temps temperature temperatures temperatur".split()),
    "torque": frozenset("tau taus torque torques trq effort efforts moment moments drehmoment nm".split()),
    "link_position": frozenset("ql secondary".split()),
    "velocity": frozenset(
        "dq qd qvel vel velocity velocities speed speeds qdot omega geschwindigkeit drehzahl rpm".split()
    ),
    "position": frozenset("q qpos pos position positions angle angles winkel theta lage".split()),
    "current": frozenset("i cur curr current currents strom amps iq".split()),
}
"""Signal -> words for it; the first signal with a word counts: `current position` is a position."""

UNITS_ONLY = frozenset(("nm", "rpm"))
"""Words that are units, and ambiguous without another word."""

COMMANDED = frozenset("ref cmd command commanded target des desired soll setpoint goal reference d".split())
"""Words for commanded quantities."""
OTHERS = frozenset("tcp pose cart cartesian force wrench ext err error std model gravity tool ft".split())
"""Words for quantities that are computed, or not those of a joint."""


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
