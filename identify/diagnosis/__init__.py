"""Diagnosis: which physics a model leaves out, where, and with what evidence."""

from .diagnose import diagnose
from .findings.finding import Alternative, Diagnosis, Finding, Improvement, Quantity, Remainder

__all__ = ["Alternative", "Diagnosis", "Finding", "Improvement", "Quantity", "Remainder", "diagnose"]
