"""Marks: see `markers` in pyproject.toml; a file states its own as `pytestmark`."""

import fcntl
from pathlib import Path

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests run file by file; those that keep to the clock one at a time, but for patient ones."""
    for item in items:
        clocked = item.get_closest_marker("clocked")
        alone = clocked is not None and not clocked.kwargs.get("patient")
        item.add_marker(pytest.mark.xdist_group("clock" if alone else item.path.name))


@pytest.fixture(scope="session")
def tutorial(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The folder of `parts/tutorial.py`, to read: the first worker that needs it writes it for all."""
    from .parts.tutorial import write_tutorial  # which imports all of exidyn

    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / "tutorial"
    with open(f"{folder}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (done := folder / "done").exists():
            write_tutorial(folder)
            done.touch()
    return folder
