"""Recordings that exist as the runs of a study."""

from dataclasses import replace

import pytest

from exidyn.acquire.study.rounds import Round
from exidyn.acquire.study.sources import Shelf
from exidyn.identification.errors import NotAFile
from exidyn.identification.recordings.recording import KnownPayload

from ...parts.small import two_joint_files


@pytest.fixture
def shelf(tmp_path):
    """A loaded run before an empty one in the order of their names, and what is no recording."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    body = KnownPayload("L", (("M", 3.0),))
    two_joint_files.write(
        folder, two_joint_files.run("b-empty"), replace(two_joint_files.loaded(body), name="a-loaded")
    )
    (folder / "README.md").write_text("what these are")
    return Shelf.of(folder, two_joint_files.NOMINAL)


def test_the_first_run_is_one_without_a_body_and_others_stay_on_offer(shelf, tmp_path):
    one = Round(1, tmp_path / "round-01")
    one.folder.mkdir()
    shelf.make(one, None)
    assert one.recording().name == "b-empty"
    [offer] = shelf.offers([one], None, None)
    assert offer.name == "a-loaded"
    assert offer.payload.known == (("M", 3.0),)
    assert offer.seconds == pytest.approx(20.0, abs=0.01)
    two = Round(2, tmp_path / "round-02")
    two.folder.mkdir()
    shelf.make(two, shelf.chosen(offer, tmp_path))
    assert two.recording().name == "a-loaded"
    assert shelf.offers([one, two], None, None) == []


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(NotAFile, match="no recordings there"):
        Shelf.of(tmp_path, two_joint_files.NOMINAL)
