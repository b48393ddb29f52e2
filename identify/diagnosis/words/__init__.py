"""A diagnosis in words and tables.

In: `Diagnosis`.
Out: sentences, plain tables, text.
"""
