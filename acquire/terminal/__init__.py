"""What is printed and asked in a terminal.

In: results.
Out: text, tables, progress.
"""
