"""Diagnosis: which physics a model leaves out, where, and with what evidence."""

from ..quantity import Quantity
from .diagnose import diagnose
from .findings.diagnosis import Diagnosis
from .findings.evidence import Remainder
from .findings.finding import Finding, Hypothesis

__all__ = ["Diagnosis", "Finding", "Hypothesis", "Quantity", "Remainder", "diagnose"]
