"""The closed loop and exported models, beside MuJoCo.

In: a model with values, a motion.
Out: times, trajectories, torques of both.
"""
