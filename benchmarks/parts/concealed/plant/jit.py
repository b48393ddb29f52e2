"""Numba's compiler, where it is installed: without it everything is the same and a thousand times slower."""

import sys

try:
    from numba import njit
except ImportError:
    print(
        "numba is not installed: arms are simulated a thousand times slower. pip install '.[bench]'",
        file=sys.stderr,
    )

    def njit(**_options):  # type: ignore[no-untyped-def, no-redef]
        """Leave functions as they are."""
        return lambda function: function


__all__ = ["njit"]
