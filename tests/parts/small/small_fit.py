"""A fit of the arm in two_joints.py, from files' worth of simulated recordings."""

from dataclasses import replace
from functools import cache

from exidyn.identification.document.text import text
from exidyn.identification.effects import FrictionAsymmetry
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.pages.fit_document import fit_document
from exidyn.identification.preparation.prepare import Prepared, prepare
from exidyn.identification.recordings.recording import KnownPayload

from . import two_joints
from .two_joint_files import NOMINAL, loaded, run


@cache
def fit() -> Fit:
    """With a known payload, a run held out, a warning, and friction asked for that the arm does not have."""
    runs = [run("empty"), loaded(KnownPayload("L", two_joints.MASS))]
    other = run("other", 2, 3).with_warnings("the cable was caught at the base")
    return identify(runs, [other], model=NOMINAL + FrictionAsymmetry())


@cache
def plain_fit() -> Fit:
    """From one run without payload, all parameters kept."""
    return identify([run("empty")], drop=False)


def other_run() -> Prepared:
    """A run with the payload that neither fit has seen."""
    known = KnownPayload("L", two_joints.MASS)
    recording = replace(loaded(known), name="new", model=fit().model)
    return prepare(recording, fit().filtering)


def summary(fit: Fit) -> str:
    """The page of a fit as text."""
    return text(fit_document(fit))
