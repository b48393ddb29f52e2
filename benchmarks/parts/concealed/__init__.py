"""Concealed cases: drawn (`case`), answered (`answerers`), swept through strengths (`sweep`).

In: an arm, an effect, a strength.
Out: folders of cases as a user would have them, truths beside them, scores of answers.
"""
