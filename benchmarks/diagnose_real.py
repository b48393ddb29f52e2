"""Real arms with real physics taken out of the belief: is it named, and what is found with all there?

The belief is a fit to some runs, with tolerances; other runs, of other days where there are any, are
diagnosed, and further ones held out. What is found with nothing taken out is what the plain model of
friction leaves of a real gear: it is listed with what it is on each set of runs, and is not counted as new
where something was taken out.
"""

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread a process, and two processes

from common import options, save
from diagnose_real_answer import Question, ask, belief
from diagnose_real_arms import ARMS, Asked, Loaded, parts
from diagnose_real_belief import scatter
from diagnose_real_tables import bodies_table, nothing_table, scatter_table, taken_table
from real_data import FOLDER, UR10E

PROCESSES = 2
QUICK = (("kr300", "rotor_inertia", 4), ("panda", "coulomb_friction", 3))
"""What is taken out where there is little time: arm, effect, joint from 0."""


def questions() -> Iterator[Question]:
    """An arm after the other: with payloads hidden, with nothing taken out, with each term taken out."""
    for key, arm in ARMS.items():
        for body in arm.bodies:
            yield hidden(key, body)
        for asked in arm.asked:
            yield Question(key, asked, known=arm.known)
        for effect, joint in product(arm.terms, range(arm.data.model().robot.dof)):
            yield Question(key, arm.asked[0], effect, joint, arm.known)


def few_questions() -> Iterator[Question]:
    """One of each kind, the longest first; a third of a run for the payload."""
    body = ARMS["ur10e"].bodies[0]
    [name] = body.asked.fitted
    yield hidden("ur10e", body._replace(asked=Asked(parts(name, 1), parts(name, 2))))
    for key, effect, joint in QUICK:
        yield Question(key, ARMS[key].asked[0], effect, joint, ARMS[key].known)


def hidden(key: str, body: Loaded) -> Question:
    """Of runs with a payload that the belief does not know of."""
    return Question(key, body.asked, "payload", -1, body.known, body.mass, body.drawn)


def scattered(key: str) -> dict[str, Any]:
    """How far fits to single runs of an arm differ; to those that are diagnosed too where few were fitted."""
    arm = ARMS[key]
    names = dict.fromkeys([*arm.believed, *(name for asked in arm.asked for name in asked.fitted)])
    return scatter(arm, belief(key, arm.known), list(names))


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    if not (FOLDER / UR10E.urdf).exists():
        print(f"no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
        return
    results: dict[str, Any] = {}
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        said = list(pool.map(ask, few_questions() if chosen.quick else questions()))
        spread = {} if chosen.quick else dict(zip(ARMS, pool.map(scattered, ARMS), strict=True))
    results |= bodies_table([one for one in said if one.question.effect == "payload"])
    nothing = [one for one in said if not one.question.effect]
    results |= nothing_table(nothing)
    results |= taken_table([one for one in said if one.question.joint >= 0], nothing)
    if spread:
        results |= scatter_table(spread)
    save(chosen.json, results)


if __name__ == "__main__":
    main()
