"""Effects of installed packages, by the entry-point group `exidyn.effects`: name -> subclass of `Effect`."""

from importlib import metadata

from ..errors import EffectError
from .effect import Effect

GROUP = "exidyn.effects"
"""Entry points of this group are effects; their names are those of robot files and of the diagnosis."""


def installed(known: dict[str, type[Effect]]) -> dict[str, type[Effect]]:
    """Effects of all installed packages.

    Args:
        known: Effects that there are already, whose names no other may use.

    Raises:
        EffectError: A package has an effect that cannot be loaded, is none, or has a name that is taken.
    """
    found: dict[str, type[Effect]] = {}
    for entry in metadata.entry_points(group=GROUP):
        taken = known | found
        if taken.get(entry.name) is None:
            found[entry.name] = _loaded(entry)
        elif f"{taken[entry.name].__module__}:{taken[entry.name].__qualname__}" != entry.value:
            raise EffectError(f"{_where(entry)}: the name is taken. Give the entry point another name")
    return found


def _loaded(entry: metadata.EntryPoint) -> type[Effect]:
    try:
        kind = entry.load()
    except Exception as error:  # whatever somebody else's module raises
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise EffectError(
            f"{_where(entry)} cannot be loaded from {entry.value}: {reason}. Repair or uninstall the package"
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Effect)):
        raise EffectError(f"{_where(entry)}: {entry.value} is no subclass of exidyn.identify.effects.Effect")
    return kind


def _where(entry: metadata.EntryPoint) -> str:
    package = entry.dist.name if entry.dist else "an unknown package"
    return f"effect '{entry.name}' of the package {package}"
