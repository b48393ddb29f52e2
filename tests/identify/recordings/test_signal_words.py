"""The import reads columns by the same words as init does."""

import numpy as np
import pytest

from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.tables.column_names import signal_of
from exidyn.identification.recordings.tables.name_index import UNITS_ONLY, WORDS

from ...parts.small import two_joints

PATTERNS = ("{joint}_{word}", "{word}_{joint}", "{word}{number}")
NAMED = [(signal, word) for signal, words in WORDS.items() for word in sorted(words - UNITS_ONLY)]


@pytest.mark.parametrize(
    ("signal", "word", "pattern"), [(*pair, PATTERNS[place % 3]) for place, pair in enumerate(NAMED)]
)
def test_every_word_names_its_signal(tmp_path, pattern, signal, word):
    model, time = two_joints.model(), np.arange(0.0, 1.0, 0.01)
    columns = {"t": time}
    random = np.random.default_rng(0)
    for place, joint in enumerate(model.robot.joints):
        usual = {"position": f"q{place + 1}", "torque": f"tau{place + 1}"}
        values = np.sin(time + place) if signal != "temperature" else 30.0 + 0.1 * time
        column = pattern.format(joint=joint, word=word, number=place + 1)
        for other, name in usual.items():
            if other != signal:
                columns[name] = random.normal(size=len(time)) if other == "torque" else np.sin(time + place)
        columns[column] = values
    path = tmp_path / "run.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns))
    [recording] = import_source(path, model)
    assert signal in recording.signals
    assert signal_of(f"{word} x") in (signal, "position")  # that of the words `q` and `pos` in two tables
