"""The page docs/proof.md.

In: diagnoses of public recordings.
Out: the page, its pictures, open-loop predictions.
"""
