"""Plans of two joints: a sample of every family, and a known plan of the two-joint arm."""

import numpy as np

from exidyn.trajectories.families.chirp import Chirp
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.families.sequence import Sequence
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.trajectory import State

from ..small import two_joints


def fourier(periods=2, seed=0, harmonics=5):
    """Numbers with all their digits."""
    sine, cosine = 0.1 * np.random.default_rng(seed).normal(size=(2, 2, harmonics))
    return Fourier(10.0 / 3.0, np.array([0.1, -1.0 / 7.0]), sine, cosine, periods)


def phases(seed=1):
    random = np.random.default_rng(seed)
    state = State(random.normal(size=2), 0.1 * random.normal(size=2), np.zeros(2))
    return Phases.of_jerks(state, random.uniform(0.1, 0.5, 4), random.normal(size=(4, 2)))


def chirp():
    """On the second joint only."""
    largest = np.array([[0.1, 1.0 / 3.0, 2.0, 50.0]])
    return Chirp(fourier(), (1,), largest, 1.0, 7.0, 0.5, 4.0, 1.0 / 3.0, logarithmic=False)


def sequence():
    """Rests, leads and a core, of which each is a family of its own, and a sequence inside."""
    core = Fourier(2.0, np.array([0.1, -0.2]), 0.1 * np.ones((2, 2)), np.zeros((2, 2)))
    whole = with_leads(core, two_joints.arm().limits, 0.004)
    return Sequence((Sequence(whole.parts[:2]), *whole.parts[2:]))


SAMPLES = {"chirp": chirp, "fourier": fourier, "phases": phases, "sequence": sequence}
"""Family -> a function that makes one of two joints; a new family needs a line here."""


def known_plan(trajectory=None, **options):
    """A plan of the two-joint arm with something in every field."""
    options = {
        "margins": {"velocity": 0.02, "self collision": 0.05},
        "criterion": "condition",
        "reached": 1.0 / 3.0,
        "details": {"solver": 'SLSQP "quoted" \\ \n next', "largest std": float("nan"), "seconds": 1e-7},
        "seed": 12,
        "tick": 0.004,
        "payload_pair": True,
        "assumed": ("no wind", "the ü in Müller stays"),
    } | options
    return Plan.of(trajectory or fourier(), two_joints.model(), **options)
