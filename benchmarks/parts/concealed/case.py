"""Draws concealed cases: which arm, what is wrong with it, how strongly, and which runs are recorded."""

import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .effects import OUTSIDE, VOCABULARY, Conceal, places
from .plant.closed_loop import SETTLE, STEP, run
from .record import PLANS, SECONDS, Run, record
from .robot import ARMS, Robot, honest
from .scoring import DETECTABLE
from .strength import Bench, conceal, torques, with_peak
from .write import truth_of, write_case, write_truth

TIERS = {"edge": (0.3, 1.0), "middle": (1.0, 3.0), "clear": (3.0, 10.0)}
"""Visibility: rms of the effect's torque over the noise floor."""
EVIDENT = {"edge": 0.0, "middle": 2 * DETECTABLE, "clear": 5 * DETECTABLE}
"""Evidence at least: what is called clear, an oracle could find in a fifth of the data."""
WITH_A_LOAD = {"drive_gain", "encoder_offset"}
"""Effects that mostly take a payload run to be distinguished from the inertias."""
SEPARATE = {"joint_elasticity", "backlash", "time_delay", "kinematic_coupling", "hysteresis"}
"""Effects of motion in the small, of which a double has no more than one."""
HALVINGS = 5
"""Times that effects are halved with which an arm falls."""
BEYOND = 0.5
"""How far beyond a joint's limits its encoder may read, whose zero may be wrong [rad]."""


@dataclass(frozen=True)
class Draw:
    """A case before it is simulated."""

    name: str  # Of the case
    arm: str  # Key of ARMS
    kind: str  # none, single, double or outside
    tier: str  # Key of TIERS; empty for none
    effects: tuple[str, ...]  # What is concealed, in order
    wanted: tuple[float, ...]  # Visibility of each
    seed: int  # Of everything random in it
    seconds: float = SECONDS  # Length of a run
    tries: int = 4  # Simulations to find the strength that is visible as wanted


def draw(
    name: str, kind: str, effects: tuple[str, ...], tier: str, seed: int, arm: str | None = None
) -> Draw:
    """A case of these effects, on any arm, somewhere within a tier."""
    rng = np.random.default_rng([seed, 0])
    # Where temperatures are not recorded, they cannot be shown to be the cause.
    arms = list(ARMS) if "temperature_dependent_friction" not in effects else ["kr270", "ur10like"]
    chosen = arm or arms[rng.integers(len(arms))]
    low, high = np.log(TIERS[tier]) if tier else (0.0, 0.0)
    wanted = tuple(float(np.exp(rng.uniform(low, high))) for _ in effects)
    return Draw(name, chosen, kind, tier, effects, wanted, seed)


def known_effects() -> dict[str, Conceal]:
    """Those of the vocabulary, and those outside it."""
    return VOCABULARY | OUTSIDE


def make(case: Draw, cases: Path, truths: Path) -> Path:
    """Simulate a case; its folder goes into `cases`, its truth into `truths`.

    Returns:
        The folder.
    """
    rng = np.random.default_rng([case.seed, 4])
    loaded = bool(rng.random() < (0.75 if WITH_A_LOAD & set(case.effects) else 0.4))
    bench = Bench(case.seed, loaded, case.seconds)
    sound = with_peak(honest(ARMS[case.arm](), rng), bench)
    names = ["identify_a", "identify_b", "validate", *["payload"] * loaded, "slow"]
    for halved in range(HALVINGS):
        # Where the arm has fallen, it may be as weak as it has to be, whatever its tier.
        wanted = tuple(strength * 0.5**halved for strength in case.wanted)
        weaker = replace(case, wanted=wanted, tier="edge" if halved else case.tier)
        robot, effects = concealing(sound, weaker, bench, copy.deepcopy(rng))
        runs = [record(robot, PLANS[name], case.seed, case.seconds) for name in names]
        if all(stands(robot, one) for one in runs):
            break
    write_case(cases / case.name, robot, runs)
    about = {"kind": case.kind, "tier": case.tier, "seed": case.seed}
    write_truth(truths, case.name, about | truth_of(robot, effects, runs[2]))
    return cases / case.name


def stands(robot: Robot, one: Run) -> bool:
    """Whether an arm stayed where its joints can go; a drive too weak for a payload drops it."""
    limits = robot.arm.limits
    return bool(np.all(one.position > limits.lower - BEYOND) and np.all(one.position < limits.upper + BEYOND))


def warm_up() -> None:
    """Compile the plant here, so that no two processes do it side by side; numba keeps it for them."""
    robot = honest(ARMS["ur10like"](), np.random.default_rng(0))
    n = robot.arm.joints
    still = np.tile(robot.arm.home, (3, 8, 1)) * np.array([1.0, 0.0, 0.0])[:, None, None]
    log = run(robot.machine, still, np.zeros((8 + round(SETTLE / STEP), n)), np.zeros(n))
    torques(robot.machine.body, *log[:3])


def concealing(
    robot: Robot, case: Draw, bench: Bench, rng: np.random.Generator
) -> tuple[Robot, list[dict[str, Any]]]:
    """The robot with everything that a case conceals, and its truth about each."""
    truth: list[dict[str, Any]] = []
    taken: set[int] = set()
    for name, wanted in zip(case.effects, case.wanted, strict=True):
        there = [joint for joint in places(name, robot) if joint not in taken]
        joint, effect = int(rng.choice(there)), known_effects()[name]
        evident = EVIDENT.get(case.tier, 0.0)
        concealed, strength = conceal(robot, effect, joint, wanted, evident, bench, case.tries)
        robot = concealed.robot
        taken |= set(concealed.joints)
        truth.append({
            "effect": name,
            "joints": [joint + 1 for joint in concealed.joints],
            "parameters": concealed.parameters,
            "visibility": strength.visibility,
            "visibility_by_joint": strength.by_joint,
            "beyond_prior": strength.beyond_prior,
            "evidence": strength.evidence,
        })  # fmt: skip
    return robot, truth


def singles(seed: int, tier: str = "clear") -> list[Draw]:
    """One case of every effect of the vocabulary."""
    return [
        draw(f"{effect}_{tier}", "single", (effect,), tier, seed + k) for k, effect in enumerate(VOCABULARY)
    ]


def nothing(seed: int, count: int) -> list[Draw]:
    """Cases in which nothing is wrong, the arms in turn."""
    return [draw(f"none_{k + 1}", "none", (), "", seed + k, list(ARMS)[k % len(ARMS)]) for k in range(count)]


def doubles(seed: int, count: int) -> list[Draw]:
    """Cases of two effects at once, each well visible."""
    rng, drawn = np.random.default_rng(seed), []
    while len(drawn) < count:
        pair = tuple(str(name) for name in rng.choice(list(VOCABULARY), 2, replace=False))
        if not set(pair) <= SEPARATE:
            k = len(drawn) + 1
            drawn.append(draw(f"double_{k}", "double", pair, "clear", seed + k))
    return drawn


def outside(seed: int, tier: str = "clear") -> list[Draw]:
    """One case of everything that has no name."""
    return [
        draw(f"{effect}_{tier}", "outside", (effect,), tier, seed + k) for k, effect in enumerate(OUTSIDE)
    ]


def concealed_set(seed: int) -> list[Draw]:
    """The whole benchmark, in an order and under names without meaning."""
    base = 10_000 * seed
    cases = [case for k, tier in enumerate(TIERS) for case in singles(base + 100 * k, tier)]
    cases += nothing(base + 1000, 20) + doubles(base + 2000, 20)
    cases += outside(base + 3000) + outside(base + 3100, "middle")
    order = np.random.default_rng(seed).permutation(len(cases))
    return [replace(cases[k], name=f"c{place + 1:03d}") for place, k in enumerate(order)]


def quick_set(seed: int) -> list[Draw]:
    """Four cases of short runs, at the strength of their scale."""
    base = 10_000 * seed + 9000
    cases = [
        draw("q1", "none", (), "", base, "ur10like"),
        draw("q3", "single", ("coulomb_friction",), "clear", base + 2, "kr270"),
        draw("q5", "double", ("joint_spring", "viscous_friction"), "clear", base + 4, "ur10like"),
        draw("q6", "outside", ("floor_vibration",), "clear", base + 5, "ur10like"),
    ]
    return [replace(case, seconds=12.0, tries=1) for case in cases]
