"""The process in which FIGAROH searches its trajectory.

Used as its UR10 example does: `load_robot`, a YAML file in its unified format with the settings of that
example (7 way-points, 2 s each, 20 Hz, 100 IPOPT iterations, one segment), a subclass of its
`BaseOptimalTrajectory`, `initialize`, `solve`. While the budget lasts, it is started anew with other
random numbers.
"""

import contextlib
import json
import logging
import os
import signal
import tempfile
import traceback
import warnings
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from ..excite.arm import RATE, Arm, States
from ..excite.peers import CLOCK, DURATION

WAY_POINTS = 7
"""Of FIGAROH's UR10 example, two seconds apart."""
TICK = 0.5
"""Between looks at the clock [s]."""


class FigarohSettings(NamedTuple):
    """What a user of FIGAROH chooses; the defaults are those of its UR10 example."""

    # Minimise the condition number that is judged here, of our base columns scaled to unit length, in place
    # of FIGAROH's own of its base columns as they are
    unit_columns: bool = False
    way_points: int = WAY_POINTS  # In the same time; more give it more freedom

    @property
    def name(self) -> str:
        """What to call it in a table."""
        parts = ["FIGAROH"]
        if self.unit_columns:
            parts.append("with this criterion")
        if self.way_points != WAY_POINTS:
            parts.append(f"{self.way_points} way-points")
        return ", ".join(parts)


@dataclass
class FigarohRun:
    """What the process reports: iterates with the seconds at which they were reached, and what it logged."""

    iterates: list[tuple[float, States]]
    seconds: float
    attempts: int
    accepted: int
    complaints: list[str] = field(default_factory=list)


def work(pipe: Connection, arm: Arm, budget: float, seed: int, settings: FigarohSettings) -> NoReturn:
    """The process: attempts until the budget is used up, then report and end from wherever it is."""
    _silence()
    warnings.simplefilter("ignore")  # two of its dependencies register the same converters
    try:
        watch = _Watch(pipe, budget)
        np.random.seed(seed)  # noqa: NPY002 -- FIGAROH draws from the global generator
        figaroh = _prepared(arm, settings, watch)
        watch.start()
        while True:
            np.random.seed(seed + 1000 * watch.attempts)  # noqa: NPY002 -- unlike the next seed's
            watch.attempts += 1
            figaroh.solve(stack_reps=1)
            watch.accepted = len(figaroh.results["T_F"])
    except Exception:
        pipe.send(traceback.format_exc())
        raise


def _silence() -> None:
    """IPOPT prints from C, so the descriptor itself goes nowhere."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)


class _Watch(logging.Handler):
    """Keeps FIGAROH's iterates and complaints, and ends the process when the budget is used up."""

    def __init__(self, pipe: Connection, budget: float) -> None:
        super().__init__(logging.WARNING)
        self.pipe, self.budget = pipe, budget
        self.began = np.inf
        self.attempts = self.accepted = 0
        self.iterates: list[tuple[float, Any, np.ndarray]] = []
        self.complaints: list[str] = []
        logging.getLogger("figaroh").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        if "not enforced" not in record.getMessage():  # collision was not asked for
            self.complaints.append(record.getMessage())

    def start(self) -> None:
        """Count from now on; FIGAROH calls nothing of ours while it looks for clear way-points."""
        self.began = CLOCK()
        signal.signal(signal.SIGALRM, lambda *_: self.look())
        signal.setitimer(signal.ITIMER_REAL, TICK, TICK)

    def keep(self, problem: Any, way_points: np.ndarray) -> None:
        """Remember an iterate."""
        self.iterates.append((CLOCK() - self.began, problem, np.array(way_points, float)))

    def look(self) -> None:
        """Report and end the process if the budget is used up."""
        if CLOCK() - self.began < self.budget:
            return
        signal.setitimer(signal.ITIMER_REAL, 0.0)  # not again while it reports
        seconds = CLOCK() - self.began
        within = [kept for kept in self.iterates if kept[0] <= self.budget]
        sampled = [(when, _sampled(problem, x)) for when, problem, x in within]
        self.pipe.send(FigarohRun(sampled, seconds, self.attempts, self.accepted, self.complaints))
        self.pipe.close()
        os._exit(0)  # out of IPOPT's C code there is no other way at once


def _sampled(problem: Any, way_points: np.ndarray) -> States:
    """FIGAROH's own spline through way-points, sampled densely."""
    table = np.vstack((problem.wp_init, way_points.reshape(problem.n_wps - 1, problem.n_joints)))
    _, *states = problem.opt_traj.CB.get_full_config(
        RATE, problem.tps, table.T, problem.vel_wps, problem.acc_wps
    )
    return States(*states)


def _prepared(arm: Arm, settings: FigarohSettings, watch: _Watch) -> Any:
    """FIGAROH's optimiser of this arm, initialised."""
    from figaroh.tools.load_robot import load_robot

    robot = load_robot(str(arm.urdf), package_dirs=str(arm.packages), load_by_urdf=True)
    robot.geom_model = None
    joints = list(arm.model.robot.joints)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        file = Path(folder) / "arm.yaml"
        file.write_text(json.dumps(_configuration(joints, arm.margin, settings)))  # JSON is YAML
        figaroh = _subclass(watch, arm, settings.unit_columns)(robot, joints, str(file))
        # FIGAROH leaves it to the user to name which model columns the joints are.
        every = list(range(len(joints)))
        figaroh.identif_config |= {"act_idxq": every, "act_idxv": every}
        figaroh.initialize()
    return figaroh


def _subclass(watch: _Watch, arm: Arm, unit_columns: bool) -> Any:
    """The subclass that FIGAROH wants for each robot, with ears."""
    from figaroh.optimal.base_optimal_trajectory import BaseOptimalTrajectory, BaseTrajectoryIPOPTProblem
    from figaroh.tools.regressor import build_regressor_basic

    class Problem(BaseTrajectoryIPOPTProblem):
        def objective(self, X: np.ndarray) -> float:  # noqa: N803 -- FIGAROH's name
            watch.look()
            return super().objective(X)

        def constraints(self, X: np.ndarray) -> np.ndarray:  # noqa: N803
            watch.look()
            return super().constraints(X)

        def gradient(self, X: np.ndarray) -> np.ndarray:  # noqa: N803
            watch.keep(self, X)  # asked once at every iterate that is accepted
            return super().gradient(X)

        def solve_with_waypoints(self, wps: np.ndarray) -> tuple[bool, dict[str, Any]]:
            success, results = super().solve_with_waypoints(wps)
            if "x_opt" in results:
                watch.keep(self, results["x_opt"])
            return success, results

    class ArmTrajectory(BaseOptimalTrajectory):
        def create_ipopt_problem(self, *arguments: Any) -> Problem:
            return Problem(self, *arguments)

        def initialize(self) -> None:
            super().initialize()
            if unit_columns:
                states = States(*np.random.default_rng(0).normal(size=(3, 50, arm.dof)))
                theirs = build_regressor_basic(self.robot, *states, self.identif_config)
                self.columns = _same_columns(arm, states, theirs)

        def _stack_base_regressors(self, *states: Any, W_stack: Any = None) -> np.ndarray:  # noqa: N803
            if not unit_columns:
                return super()._stack_base_regressors(*states, W_stack=W_stack)
            columns = build_regressor_basic(self.robot, *states, self.identif_config)[:, self.columns]
            return columns / np.linalg.norm(columns, axis=0)

    return ArmTrajectory


def _same_columns(arm: Arm, states: States, theirs: np.ndarray) -> np.ndarray:
    """Which of FIGAROH's regressor columns, all rows of joint 1 first, our base columns are."""
    t, n = states.position.shape
    ours = arm.base_regressor(states).reshape(t, n, -1).swapaxes(0, 1).reshape(t * n, -1)
    length = np.outer(np.linalg.norm(ours, axis=0), np.maximum(np.linalg.norm(theirs, axis=0), 1e-12))
    alike = np.abs(ours.T @ theirs) / length
    if np.min(np.max(alike, axis=1)) < 1.0 - 1e-9:
        raise ValueError("FIGAROH's regressor lacks a column of ours")
    return np.argmax(alike, axis=1)


def _configuration(joints: list[str], margin: float, settings: FigarohSettings) -> dict[str, Any]:
    """FIGAROH's unified configuration with the settings of its UR10 example."""
    components = {"friction": False, "actuator_inertia": False, "joint_offset": False}
    problem = {"soft_lim": margin, "max_attempts": 500, "max_iterations": 100}
    apart = DURATION / (settings.way_points - 1)
    trajectory = {"waypoints": settings.way_points, "frequency": 20, "segment_duration": apart}
    unknown = [0.0] * len(joints)
    mechanics = {
        "friction_coefficients": {"viscous": unknown, "static": unknown},
        "actuator_inertias": unknown,
        "joint_offsets": unknown,
    }
    return {
        "robot": {
            "name": "arm",
            "properties": {"joints": {"active_joints": joints}, "mechanics": mechanics},
        },
        "tasks": {
            "identification": {
                "problem": {"use_joint_torques": True, "model_components": components},
                "signal_processing": {"sampling_frequency": 500.0, "cutoff_frequency": 50.0},
            },
            "optimal_trajectory": {"problem": problem, "trajectory": trajectory},
        },
    }
