"""Damaged files of a store are refused in one line that says which, and what to do."""

import json

import pytest

from exidyn.acquire.fleet.store import CHANGES, Store
from exidyn.identification.errors import NotAFile

from ...parts.runs import kept_files, parser_files


@pytest.fixture
def store(tmp_path):
    parser_files.write(kept_files.fleet_store(), tmp_path / "store")
    return Store(tmp_path / "store")


def test_a_store_is_read(store):
    assert [len(runs) for runs in store.arms(kept_files.KIND).values()] == [3]
    assert len(store.index()) == 3
    assert len(store.changes(kept_files.ARM)) == 1


@pytest.mark.parametrize("name", [CHANGES, "runs"])
def test_a_file_that_is_no_table_is_named(store, name):
    path = next(iter([store.folder / CHANGES] if name == CHANGES else store.runs.rglob("*.parquet")))
    path.write_bytes(b"no table")
    with pytest.raises(NotAFile, match=rf"{path.name}: .*Remove that file; exidyn fleet then recreates it"):
        store.changes(kept_files.ARM) if name == CHANGES else store.index()


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("factors", [1.0], "factors: expected .* values, 2 triangles"),
        ("counts", [1, 2, 3], "temperature: expected 3 values, one per joint; found 2"),
        ("seconds", -1.0, "seconds: expected float > 0"),
        ("date", "1950-01-01T00:00:00+00:00", "date: expected a date in UTC from 1970"),
        ("noise", [0.0, 1.0], r"noise\[0\]: expected float >= 1e-30"),
        ("file", "a\0b", "file: expected no character of code 0"),
    ],
)
def test_a_value_that_cannot_be_is_named(store, key, value, message):
    path = sorted(store.runs.rglob("*.parquet"))[0]
    rows = json.loads(kept_files.rows_of(path.read_bytes()))
    rows[0][key] = value
    path.write_bytes(kept_files.parquet_of(json.dumps(rows).encode()))
    with pytest.raises(NotAFile, match=message):
        store.arms(kept_files.KIND)


def test_a_type_of_another_arm_is_refused(store):
    kind = store.folder / "kinds" / f"{kept_files.KIND}.json"
    text = kind.read_text().replace('"rate": ', '"rate": null, "was": ')
    kind.write_text(text)
    with pytest.raises(NotAFile, match="Remove that file"):
        store.kind(kept_files.KIND)
