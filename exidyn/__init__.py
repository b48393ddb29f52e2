"""Find out what a robot arm's dynamics really are: excite, record, identify, diagnose.

    import exidyn as ex

    log = ex.read("run.mcap")
    fit = ex.identify(log)
    print(fit)
    ex.report(fit, "report.html")

These names, all of `exidyn.api`, are imported when they are asked for, so that `exidyn --help` need not load
Pinocchio.
"""

from importlib import import_module, metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import *  # noqa: F403

__version__ = metadata.version("exidyn")

if not Path(__file__).with_name("identify").exists():
    # A checkout: the packages lie beside this folder (see setup.py), where Python started there finds them.
    __path__.append(str(Path(__file__).parents[1]))  # noqa: F405

# `exidyn.identify` is a package and a function. Importing the package binds the name here, the first time:
# unbound again, it is left to the function, and `from exidyn.identify.model import Model` works as ever.
import_module(".identify", __name__)
del globals()["identify"]


def __getattr__(name: str) -> Any:
    if name.startswith("_"):  # asked for by Python's own tools
        raise AttributeError(name)
    if name not in __dir__():
        raise AttributeError(f"exidyn has no '{name}'. It has: {', '.join(__dir__())}")
    return getattr(import_module(".api", __name__), name)


def __dir__() -> list[str]:
    return [*import_module(".api", __name__).__all__, "__version__"]
