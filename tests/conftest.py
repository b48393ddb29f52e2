"""Marks: see `markers` in pyproject.toml; a file states its own as `pytestmark`."""

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that keep to the clock run one at a time; patient ones run beside one of them, file by file."""
    for item in items:
        if (clocked := item.get_closest_marker("clocked")) is not None:
            group = item.path.name if clocked.kwargs.get("patient") else "clock"
            item.add_marker(pytest.mark.xdist_group(group))
