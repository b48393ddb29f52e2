"""Options that all commands on a fleet's results share."""

import argparse
from pathlib import Path

from .common import positive

FOLDER = Path("exidyn-fleet")
"""Where results are kept unless a person says otherwise."""


def add_alarms(parser: argparse._ActionsContainer) -> None:
    """Add --alarms-per-arm-year."""
    parser.add_argument(
        "--alarms-per-arm-year",
        type=positive,
        default=1.0,
        metavar="N",
        help="false alarms to accept, over all parameters of an arm; default: 1",
    )
