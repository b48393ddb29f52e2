"""The folders at the top of the repository become packages inside `exidyn`; all else is in pyproject.toml."""

from setuptools import find_packages, setup

FOLDERS = ("acquire", "drivers", "identify", "trajectories")

setup(
    packages=[
        "exidyn",
        *(f"exidyn.{name}" for top in FOLDERS for name in (top, *(f"{top}.{x}" for x in find_packages(top)))),
    ],
    package_dir={f"exidyn.{top}": top for top in FOLDERS},
)
