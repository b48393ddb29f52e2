"""Output and questions in a terminal.

In: results.
Out: text, tables, progress.
"""
