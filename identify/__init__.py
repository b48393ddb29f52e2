"""From recordings to a robot arm's dynamics.

The names below are imported when they are asked for, so that `exidyn --help` need not load Pinocchio.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .estimators import ESTIMATORS as ESTIMATORS
    from .fit import Fit as Fit
    from .fit_file import read_fit as read_fit
    from .fit_file import write_fit as write_fit
    from .fit_summary import summary as summary
    from .identification import identify as identify
    from .importers import import_source as import_source
    from .mcap_file import read_recording as read_recording
    from .mcap_file import write_recording as write_recording
    from .model import Model as Model
    from .prepare import Filtering as Filtering
    from .report import write_report as write_report
    from .robot_file import read_model as read_model

_PLACES = {
    "ESTIMATORS": "estimators",
    "Filtering": "prepare",
    "Fit": "fit",
    "Model": "model",
    "identify": "identification",
    "import_source": "importers",
    "read_fit": "fit_file",
    "read_model": "robot_file",
    "read_recording": "mcap_file",
    "summary": "fit_summary",
    "write_fit": "fit_file",
    "write_recording": "mcap_file",
    "write_report": "report",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"exidyn.identify has no '{name}'. Public names: {', '.join(_PLACES)}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(_PLACES)
