"""The vocabulary: what may be missing, and how each is asked for.

An effect that acts on single joints needs no line here: whatever is in `EFFECTS` is asked for on each joint.
"""

from collections.abc import Callable, Iterator
from functools import partial

from ...effects import EFFECTS, load_installed
from ...model import Model
from ..candidate import Candidate
from . import backlash, bodies, elastic, measurement, torque
from .unlisted import UNLISTED

Ask = Callable[[Model], Iterator[Candidate]]

OWN: dict[str, Ask] = {
    "link_inertia": bodies.links,
    "payload": bodies.payloads,
    "base_tilt": bodies.tilts,
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
"""Name in the vocabulary -> its hypotheses for a model, every joint and shape, where it has its own way."""


def vocabulary() -> dict[str, Ask]:
    """The same of every name: those of `OWN`, and all effects that act on single joints.

    Raises:
        EffectError: An installed package has an effect that cannot be loaded.
    """
    load_installed()
    return _every()


def _every() -> dict[str, Ask]:
    single = [name for name, kind in EFFECTS.items() if torque.on_single_joints(kind) and name not in OWN]
    return OWN | {name: partial(torque.on_each_joint, name=name) for name in single}


CANDIDATES = _every()
"""The vocabulary without effects of installed packages."""


def candidates(model: Model) -> Iterator[Candidate]:
    """All hypotheses, also of what has no name in the vocabulary."""
    for ask in (*vocabulary().values(), *UNLISTED.values()):
        yield from ask(model)
