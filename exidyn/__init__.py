"""Identify the dynamics of robot arms: excite, record, identify, diagnose.

    import exidyn as ex

    log = ex.read("run.mcap")
    fit = ex.identify(log)
    print(fit)
    ex.report(fit, "report.html")

The names of `exidyn.api` are imported on first use, so that `exidyn --help` does not load Pinocchio.
"""

import sys
from importlib import import_module, metadata
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import *  # noqa: F403

__version__ = metadata.version("exidyn")

if not Path(__file__).with_name("identification").exists():
    # In a checkout, the packages are beside this folder (see setup.py). The folder `identify` is the package
    # `identification`, since `exidyn.identify` is a function.
    __path__.append(str(Path(__file__).parents[1]))  # noqa: F405
    _spec = spec_from_file_location(
        f"{__name__}.identification", Path(__file__).parents[1] / "identify" / "__init__.py"
    )
    if _spec and _spec.loader:
        identification = sys.modules[_spec.name] = module_from_spec(_spec)
        _spec.loader.exec_module(identification)


def __getattr__(name: str) -> Any:
    if name.startswith("_"):  # special names, which Python itself looks up
        raise AttributeError(name)
    if name not in __dir__():
        raise AttributeError(f"exidyn has no '{name}'. It has: {', '.join(__dir__())}")
    return getattr(import_module(".api", __name__), name)


def __dir__() -> list[str]:
    return [*import_module(".api", __name__).__all__, "__version__"]
