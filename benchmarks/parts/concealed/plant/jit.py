"""Numba's compiler, where it is installed: without it everything is the same and a thousand times slower."""

try:
    from numba import njit
except ImportError:

    def njit(**_options):  # type: ignore[no-untyped-def, no-redef]
        """Leave functions as they are."""
        return lambda function: function


__all__ = ["njit"]
