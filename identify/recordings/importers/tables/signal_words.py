"""Words for signals in the names of columns, used by the import and by proposals for a log."""

WORDS: dict[str, frozenset[str]] = {
    "temperature": frozenset("temp temps temperature temperatures temperatur".split()),
    "torque": frozenset("tau taus torque torques trq effort efforts moment moments drehmoment nm".split()),
    "link_position": frozenset("ql secondary".split()),
    "velocity": frozenset(
        "dq qd qvel vel velocity velocities speed speeds qdot omega geschwindigkeit drehzahl rpm".split()
    ),
    "position": frozenset("q qpos pos position positions angle angles winkel theta lage".split()),
    "current": frozenset("i cur curr current currents strom amps iq".split()),
}
"""Signal -> words for it; the first signal with a word counts: `current position` is a position."""

UNITS_ONLY = frozenset(("nm", "rpm"))
"""Words that are units, and ambiguous without another word."""

COMMANDED = frozenset("ref cmd command commanded target des desired soll setpoint goal reference d".split())
"""Words for commanded quantities."""
OTHERS = frozenset("tcp pose cart cartesian force wrench ext err error std model gravity tool ft".split())
"""Words for quantities that are computed, or not those of a joint."""
