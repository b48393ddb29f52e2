"""A search of a second: from one start."""

from functools import partial
from typing import Any

from exidyn.acquire.commands import excite_command
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes


def make_small(monkeypatch, **wishes: Any) -> None:
    """Let `exidyn excite` plan with these planning options of the library, and from one start."""
    monkeypatch.setattr(excite_command, "plan", partial(plan, starts=1))
    monkeypatch.setattr(excite_command, "Wishes", partial(Wishes, **wishes))
