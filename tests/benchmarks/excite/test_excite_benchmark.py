"""The benchmark of excitation: what was measured is not measured again, and what is compared."""

import json
from argparse import Namespace

import numpy as np
import pytest
from common import Kept
from excite import _cases, _compare
from parts.excite.peers import PeerResult


def test_a_run_that_was_stopped_goes_on(tmp_path):
    file = tmp_path / "figures.json.cases"
    Kept(file).of("first", lambda: {"history": [(0.5, np.float64(3.0))]})
    with file.open("a") as cut:
        cut.write('["second", {"histo')  # killed as it wrote
    again = Kept(file)
    assert again.of("first", lambda: pytest.fail("measured twice")) == {"history": [[0.5, 3.0]]}
    again.put("second", 2)
    assert Kept(file).found == {"first": {"history": [[0.5, 3.0]]}, "second": 2}


def test_cases_of_a_quick_run_are_apart(tmp_path):
    quick, full = (_cases(Namespace(json=tmp_path / "f.json", quick=quick)) for quick in (True, False))
    assert quick != full
    assert quick.parent == full.parent == tmp_path
    assert _cases(Namespace(json=None, quick=True)) is None


def result(name, *history):
    return PeerResult(name, history[-1][1], history[-1][0], list(history), "")


def test_speedup_is_of_the_time_at_which_the_best_of_the_others_ended(capsys):
    mine = [result("exidyn", (0.5, 9.0), (1.0, 5.0), (4.0, 3.0)), result("exidyn", (2.0, 4.0), (3.0, 2.5))]
    peers = {"slow": [result("slow", (10.0, 8.0), (30.0, 5.0))], "bad": [result("bad", (1.0, 7.0))]}
    ratio, speedup = _compare("peer", "exidyn", mine, peers)
    assert ratio == pytest.approx(0.5)
    assert speedup == pytest.approx(30.0 / 1.5)  # the median of our seeds
    assert "best peer: slow" in capsys.readouterr().out


def test_kept_results_are_those_that_were_measured():
    one = result("exidyn", (0.5, 9.0), (1.0, 5.0))
    assert PeerResult(**json.loads(json.dumps(vars(one)))).condition == one.condition
