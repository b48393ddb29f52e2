"""Pages: HTML, pictures and views.

In: fits, diagnoses, recordings.
Out: text of HTML and SVG; entities of a Rerun view.
"""
