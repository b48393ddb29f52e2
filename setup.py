"""The folders at the top of the repository become packages inside `exidyn`; all else is in pyproject.toml."""

from setuptools import find_packages, setup

PACKAGES = {
    "acquire": "acquire", "drivers": "drivers", "identify": "identification", "trajectories": "trajectories"
}  # fmt: skip
"""Folder -> package in `exidyn`: `exidyn.identify` is a function."""


def modules(folder: str, package: str) -> list[str]:
    """A package and all packages inside it."""
    return [f"exidyn.{name}" for name in (package, *(f"{package}.{x}" for x in find_packages(folder)))]


setup(
    packages=["exidyn", *(name for folder in PACKAGES for name in modules(folder, PACKAGES[folder]))],
    package_dir={f"exidyn.{package}": folder for folder, package in PACKAGES.items()},
)
