"""Answers beside truths.

In: answer files, truth files.
Out: tables, and figures by name.
"""
