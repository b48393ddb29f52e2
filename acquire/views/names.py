"""Names that differ, since a tab or an entity has nothing else to be known by."""

from collections.abc import Sequence


def told_apart(names: Sequence[str]) -> list[str]:
    """The names, with a number behind each that was there before: run, run #2."""
    found: list[str] = []
    for name in names:
        number, free = 1, name
        while free in found:
            number += 1
            free = f"{name} #{number}"
        found.append(free)
    return found
