"""Sensors of a simulated arm that show something else than where the joints are, when a peer is told so.

Lines on a peer's standard input: "sensor KIND JOINT TURN" (JOINT from 0, TURN of its encoder [rad]) and
"truth", which prints how far each joint has gone since: "truth LOW ... HIGH ..." [rad].
"""

import numpy as np

FAR = 1e3
"""What a position is that has no value in a telegram [rad]; a peer puts the end of its scale in its place."""
KINDS = ("saturated", "exchanged", "turned", "stale", "nan")


class Sensors:
    """Shows positions, and remembers the true ones."""

    def __init__(self):
        self.kind, self.joint, self.turn = "", 0, 0.0
        self.kept = self.low = self.high = None

    def told(self, words):
        """Take a line; whether it was for the sensors."""
        if words[0] == "sensor":
            self.low = self.high = self.kept = None
            self.joint, self.turn, self.kind = int(words[2]), float(words[3]), words[1]
            print("sensor wrong", flush=True)
        elif words[0] == "truth":
            print("truth", *np.round(self.low, 6), *np.round(self.high, 6), flush=True)
        return words[0] in ("sensor", "truth")

    def shown(self, position):
        """What is shown of true positions (n,) [rad]."""
        position = np.array(position, float)
        if not self.kind:
            return position
        self.low = position if self.low is None else np.minimum(self.low, position)
        self.high = position if self.high is None else np.maximum(self.high, position)
        self.kept = position if self.kept is None else self.kept
        shown, joint = position.copy(), self.joint
        if self.kind == "saturated":
            shown[joint] = FAR
        elif self.kind == "exchanged":
            shown[[joint, joint + 1]] = position[[joint + 1, joint]]
        elif self.kind == "turned":
            shown[joint] += self.turn
        elif self.kind == "stale":
            shown[joint] = self.kept[joint]
        elif self.kind == "nan":
            shown[joint] = np.nan
        return shown
