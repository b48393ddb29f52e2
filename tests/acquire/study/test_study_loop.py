"""The loop of a study: which steps it does, and that none is done twice."""

from dataclasses import dataclass, field

import pytest

from exidyn.acquire.study.loop import Study
from exidyn.acquire.study.rounds import CHOICE, NOTEBOOK, Round
from exidyn.acquire.terminal.json_output import json_text

from ...parts.small import two_joints
from ...parts.small.small_choice import choice


@dataclass
class Steps:
    """A source whose runs are empty files, and which fails where it is told to."""

    done: list = field(default_factory=list)
    fail: set = field(default_factory=set)

    def step(self, what):
        if what in self.fail:
            self.fail.remove(what)
            raise KeyboardInterrupt
        self.done.append(what)

    def make(self, one, chosen):
        self.step(("run", one.number, chosen and chosen.recording))
        one.run.write_text("")

    def identify(self, runs, part):
        self.step(("fit", len(runs)))


class Small(Study):
    """Believes by the number of runs alone."""

    def _diagnose_and_choose(self, every, part):
        self.source.step(("diagnosis", len(every)))
        verdict = "run" if len(every) < 3 else "undecidable"
        (part / CHOICE).write_text(json_text(choice(verdict, 10.0 * len(every))))


def study(folder, steps):
    return Small(folder, two_joints.model(), steps, 60.0, steps.identify, None, {})


EVERY = [
    step
    for number, taken in ((1, None), (2, "this"), (3, "this"))
    for step in (("run", number, taken), ("fit", number), ("diagnosis", number))
]


def test_runs_are_made_until_a_choice_says_otherwise(tmp_path):
    steps = Steps()
    assert study(tmp_path, steps).run().verdict == "undecidable"
    assert steps.done == EVERY


@pytest.mark.parametrize("fails", EVERY)
def test_a_study_that_is_interrupted_anywhere_goes_on_with_nothing_repeated(tmp_path, fails):
    steps = Steps(fail={fails})
    with pytest.raises(KeyboardInterrupt):
        study(tmp_path, steps).run()
    assert study(tmp_path, steps).run().verdict == "undecidable"
    assert steps.done == EVERY


def test_a_study_that_ended_does_nothing_more(tmp_path):
    study(tmp_path, Steps()).run()
    steps = Steps()
    assert study(tmp_path, steps).run().verdict == "undecidable"
    assert steps.done == []


def test_the_notebook_says_what_was_believed_asked_and_learned(tmp_path):
    study(tmp_path, Steps()).run()
    page = (tmp_path / NOTEBOOK).read_text()
    assert "Joint 2 has a spring." in page
    assert "A swept sine: of all available runs it is expected to give the most" in page
    assert "Hang the body on the flange." in page
    assert "Expected information 0.90 bit, realized 0.50 bit." in page
    assert "No motion settles it." in page
    assert page.count('<section id="round-') == 3
    assert "open questions over motion" in page
    assert "residual over noise floor of each joint" in page


def test_the_notebook_says_why_every_run_was_stopped(tmp_path, monkeypatch):
    study(tmp_path, Steps()).run()
    monkeypatch.setattr(Round, "stops", ["STOPPED (brake): elbow: the drive has stopped itself"])
    study(tmp_path, Steps())._write_notebook()
    page = (tmp_path / NOTEBOOK).read_text()
    assert "Runs that were stopped before their end" in page
    assert page.count("the drive has stopped itself") == 3
