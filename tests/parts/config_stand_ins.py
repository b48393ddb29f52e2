"""Stand-ins of the configuration classes of Isaac Lab and mjlab, with the fields of their sources.

Fields: Isaac Lab 3.0 (isaaclab/actuators/actuator_base_cfg.py, actuator_pd_cfg.py) and
mjlab 1.6 (mjlab/actuator/actuator.py, builtin_actuator.py, pd_actuator.py), without deprecated names.
"""

import sys
from dataclasses import dataclass, field
from types import ModuleType


@dataclass(kw_only=True)
class ActuatorBaseCfg:
    joint_names_expr: list
    stiffness: object = None
    damping: object = None
    actuator_effort_limit: object = None
    actuator_velocity_limit: object = None
    joint_effort_limit: object = None
    joint_velocity_limit: object = None
    armature: object = None
    friction: object = None
    dynamic_friction: object = None
    viscous_friction: object = None


@dataclass(kw_only=True)
class ImplicitActuatorCfg(ActuatorBaseCfg):
    pass


@dataclass(kw_only=True)
class DelayedPDActuatorCfg(ActuatorBaseCfg):
    min_delay: int = 0
    max_delay: int = 0


@dataclass(kw_only=True)
class ActuatorCfg:
    target_names_expr: tuple
    stiffness: float
    damping: float
    armature: float | None = None
    frictionloss: float | None = None
    viscous_damping: float | None = None
    delay_min_lag: int = 0
    delay_max_lag: int = 0
    effort_limit: float | None = field(default=None)


@dataclass(kw_only=True)
class BuiltinPositionActuatorCfg(ActuatorCfg):
    pass


@dataclass(kw_only=True)
class IdealPdActuatorCfg(ActuatorCfg):
    effort_limit: float = float("inf")


MODULES = {
    "isaaclab": (),
    "isaaclab.actuators": (ImplicitActuatorCfg, DelayedPDActuatorCfg),
    "mjlab": (),
    "mjlab.actuator": (BuiltinPositionActuatorCfg, IdealPdActuatorCfg),
}


def run(text, monkeypatch):
    """Names that a configuration defines if it is imported where Isaac Lab and mjlab are."""
    for name, classes in MODULES.items():
        module = ModuleType(name)
        for cls in classes:
            setattr(module, cls.__name__, cls)
        monkeypatch.setitem(sys.modules, name, module)
    names = {}
    exec(compile(text, "actuators.py", "exec"), names)
    return names
