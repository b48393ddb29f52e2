"""Whether recordings are what they claim to be: units, signs, columns and robot, before any physics."""
