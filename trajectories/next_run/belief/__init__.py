"""What is believed after a search: what else may be there, and which questions are open.

In: a search, and what runs on offer would show.
Out: the belief, with a probability for each answer to each question.
"""
