"""Pages: HTML and pictures.

In: fits, diagnoses, recordings.
Out: text of HTML and SVG.
"""
