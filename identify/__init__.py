"""From recordings to a robot arm's dynamics.

The names below are imported when they are asked for, so that `exidyn --help` need not load Pinocchio.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fit.estimators import ESTIMATORS as ESTIMATORS
    from .fit.fit import Fit as Fit
    from .fit.fit_file import read_fit as read_fit
    from .fit.fit_file import write_fit as write_fit
    from .fit.identification import identify as identify
    from .model import Model as Model
    from .pages.fit.fit_summary import summary as summary
    from .pages.fit.report import write_report as write_report
    from .preparation.prepare import Filtering as Filtering
    from .recordings.importers import import_source as import_source
    from .recordings.mcap.mcap_file import read_recording as read_recording
    from .recordings.mcap.mcap_file import write_recording as write_recording
    from .robot_files.robot_file import read_model as read_model

_PLACES = {
    "ESTIMATORS": "fit.estimators",
    "Filtering": "preparation.prepare",
    "Fit": "fit.fit",
    "Model": "model",
    "identify": "fit.identification",
    "import_source": "recordings.importers",
    "read_fit": "fit.fit_file",
    "read_model": "robot_files.robot_file",
    "read_recording": "recordings.mcap.mcap_file",
    "summary": "pages.fit.fit_summary",
    "write_fit": "fit.fit_file",
    "write_recording": "recordings.mcap.mcap_file",
    "write_report": "pages.fit.report",
}


class _Callable(ModuleType):
    """This folder, and the function of its name: a notebook calls `exidyn.identify(log)`."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return import_module("exidyn.api").identify(*arguments, **options)


sys.modules[__name__].__class__ = _Callable


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"exidyn.identify has no '{name}'. Public names: {', '.join(_PLACES)}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(_PLACES)
