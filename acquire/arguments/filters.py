"""Options of every command that filters recordings."""

import argparse

from exidyn.identify.preparation.prepare import Filtering

from .common import positive


def add_filters(found: argparse.ArgumentParser, torque_default: str = "from the data") -> None:
    """Add the cut-offs and the speed of standstill.

    Args:
        found: To what.
        torque_default: Default of the limit up to which torque is compared, in words.
    """
    usual, defaults = "from the data", {"--torque-cutoff": torque_default}
    for name, unit, meaning in (
        ("--position-cutoff", "HZ", "low-pass of positions before differentiation"),
        ("--torque-cutoff", "HZ", "up to where torque is compared"),
        ("--standstill", "RAD/S", "speed below which a joint sticks"),
    ):
        found.add_argument(
            name, type=positive, metavar=unit, help=f"{meaning}; default: {defaults.get(name, usual)}"
        )


def filtering_of(given: argparse.Namespace) -> Filtering:
    """The filters that were given."""
    return Filtering(None, given.position_cutoff, given.torque_cutoff, given.standstill)
