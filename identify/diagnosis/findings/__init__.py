"""Findings, and what is known of each kind of effect.

In: answers.
Out: `Finding`, `Diagnosis`, `Kind`, numbers with units.
"""
