"""How long a run will take: stated before it is checked, which takes the longer the longer it is."""

import sys

from exidyn.trajectories.plans.plan_summary import LONG, duration_words

from ..run.errors import NotAllowed
from .common import complaint

LONGEST = 3600.0
"""Duration of a run beyond which a person has to confirm that it is meant [s]: an arm is warm within an hour,
and ten minutes identify it."""


def check_length(planned: float, speed: float, confirmed: bool) -> None:
    """State how long a run takes if that is more than a minute, and refuse one beyond an hour.

    Args:
        planned: Duration of the motion as it was planned [s].
        speed: Share of the planned speed [-].
        confirmed: Whether a longer run is meant (--long).

    Raises:
        NotAllowed: It is longer, and not confirmed.
    """
    seconds = planned / speed
    words = f"the run takes {duration_words(seconds)} at {100 * speed:g} % of the planned speed"
    if seconds > LONGEST and not confirmed:
        raise NotAllowed(
            f"{words}; confirm a run of more than {LONGEST / 3600:g} h by --long, or give another --speed"
        )
    if seconds >= LONG:
        print(complaint(f"exidyn: {words}; checking it"), file=sys.stderr)
