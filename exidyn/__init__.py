"""Find out what a robot arm's dynamics really are: excite, record, identify, diagnose.

    import exidyn as ex

    log = ex.read("run.mcap")
    fit = ex.identify(log)
    print(fit)
    ex.report(fit, "report.html")

The folders of the repository are linked in here, so that every tool sees one package. Names are imported when
they are asked for, so that `exidyn --help` need not load Pinocchio.
"""

from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import EFFECTS as EFFECTS
    from .api import ESTIMATORS as ESTIMATORS
    from .api import compare as compare
    from .api import diagnose as diagnose
    from .api import identify as identify
    from .api import plan as plan
    from .api import read as read
    from .api import read_all as read_all
    from .api import report as report
    from .api import robot as robot
    from .api import simulate as simulate

__version__ = metadata.version("exidyn")
_OFFERED = (
    "EFFECTS", "ESTIMATORS", "compare", "diagnose", "identify", "plan", "read", "read_all", "report", "robot",
    "simulate",
)  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _OFFERED:
        raise AttributeError(f"exidyn has no '{name}'. It has: {', '.join(_OFFERED)}, __version__")
    found = getattr(import_module(".api", __name__), name)
    return import_module(".identify", __name__) if name == "identify" else found


def __dir__() -> list[str]:
    return [*_OFFERED, "__version__"]
