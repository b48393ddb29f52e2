"""What a log means: units, signs, order and robot, and how likely each mistake is."""
