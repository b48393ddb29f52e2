"""The vocabulary: what may be missing, and how each is asked for. A new one is one line here."""

from collections.abc import Callable, Iterator
from functools import partial

from ...model import Model
from ..candidate import Candidate
from . import backlash, bodies, elastic, measurement, torque
from .unlisted import UNLISTED

Ask = Callable[[Model], Iterator[Candidate]]

CANDIDATES: dict[str, Ask] = {
    "link_inertia": bodies.links,
    "payload": bodies.payloads,
    "base_tilt": bodies.tilts,
    **{name: partial(torque.on_each_joint, name=name) for name in torque.ON_EACH_JOINT},
    "coulomb_friction": torque.dry_frictions,
    "spring_balancer": torque.balancers,
    "kinematic_coupling": torque.couplings,
    "drive_gain": measurement.gains,
    "drive_gain_saturation": measurement.saturations,
    "current_clipping": measurement.clips,
    "joint_elasticity": elastic.gears,
    "backlash": backlash.plays,
    "encoder_offset": measurement.encoder_zeros,
    "time_delay": measurement.delays,
}
"""Name in the vocabulary -> its hypotheses for a model, every joint and shape."""


def candidates(model: Model) -> Iterator[Candidate]:
    """All hypotheses, also of what has no name in the vocabulary."""
    for ask in (*CANDIDATES.values(), *UNLISTED.values()):
        yield from ask(model)
