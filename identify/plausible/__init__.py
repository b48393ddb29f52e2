"""Interpretation of a log: units, signs, order of joints and robot, and the probability of each mistake."""
