"""What MJCF lacks, in MuJoCo's steps: the model's torque, and the motion of exidyn's own simulation."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.effects import (
    FrictionAsymmetry,
    Hysteresis,
    KinematicCoupling,
    LoadDependentFriction,
    NonlinearViscousFriction,
    PositionDependentFriction,
    Prior,
    SpringBalancer,
    StribeckFriction,
    TemperatureDependentFriction,
    TorqueRipple,
)
from exidyn.identification.errors import RobotError, RobotWarning
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.in_mujoco.callbacks import ARMS
from exidyn.identification.robot_files.effect_rows import FindingRow, findings_text
from exidyn.identification.robot_files.robot_file import model_text
from exidyn.identification.simulation.plant import DriveControl, Integration, Plant
from exidyn.mujoco import attach

from ...parts.small import two_joints

mujoco = pytest.importorskip("mujoco")

FINE = 2.5e-4
TICK = 0.002
POINTWISE = (
    StribeckFriction(), LoadDependentFriction(), FrictionAsymmetry(), NonlinearViscousFriction(),
    PositionDependentFriction(), TemperatureDependentFriction(), TorqueRipple(harmonic=2),
    SpringBalancer("shoulder", 0.3, 0.2, 0.4),
)  # fmt: skip
SIZES = {"Fs": 3.0, "mu": 0.1, "Fa": 1.5, "Fh": 5.0, "Kr": 300.0, "K0": 20.0, "Fv": 0.5, "Fc": 2.0}


def arm(*more):
    """The two-joint arm as it was found, of values that a fit might have."""
    model = two_joints.model(*more)
    named = zip(model.names, two_joints.true_values(model), strict=True)
    stated = {name: Prior(value, 0.1) for name, value in named if name.startswith(("Fv", "Fc", "Off"))}
    own = [p.name for effect in more for p in effect.parameters(model.robot)]
    stated |= {name: Prior(SIZES.get(name[:2], 0.8), 0.1) for name in own}
    return replace(model, stated=dict(model.stated) | stated)


def compiled(model):
    """What MuJoCo makes of the model as far as MJCF has it, a balancer left out too."""
    text = re.sub("<tendon>.*</tendon>", "", FORMATS["mjcf"].text(Portable.of(model)), flags=re.DOTALL)
    made = mujoco.MjModel.from_xml_string(text)
    return made, mujoco.MjData(made)


@pytest.fixture
def attached():
    """`Attached` whose effects are taken away after the test."""
    made = []

    def make(*given, **options):
        made.append(Attached(*given, **options))
        return made[-1]

    yield make
    for one in made:
        one.detach()
    assert not ARMS
    assert mujoco.get_mjcb_passive() is None


def test_inverse_dynamics_of_mujoco_have_the_torque_of_the_model(attached):
    model = arm(*POINTWISE)
    made, data = compiled(model)
    effects = attached(made, data, model, temperature=40.0)
    assert set(effects.effects) >= {"coulomb_friction", "spring_balancer", "load_dependent_friction"}
    motion = two_joints.motion(50)
    warm = replace(motion, temperature=np.full_like(motion.position, 40.0))
    expected = model.torque(model.loaded(warm), model.nominal_values) + made.actuator_biasprm[:, 0]
    found = np.empty_like(expected)
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:] = motion.position[row], motion.velocity[row]
        data.qacc[:] = motion.acceleration[row]
        mujoco.mj_inverse(made, data)
        found[row] = data.qfrc_inverse
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def in_plant(model, control, motion):
    plant = Plant(
        model, model.nominal_values, two_joints.GAIN, motion.position[0], control,
        integration=Integration(FINE, FINE),
    )  # fmt: skip
    return plant.follow(motion.position[1:], motion.velocity[1:], TICK).position


def in_mujoco(made, data, control, motion, step):
    """The same drives, their loop closed in every step, on straight lines between commands."""
    made.opt.timestep = step
    mujoco.mj_resetData(made, data)
    data.qpos[:] = motion.position[0]
    mujoco.mj_inverse(made, data)
    hold = data.qfrc_inverse - made.actuator_biasprm[:, 0]
    integral, seen = hold / (control.velocity_gain * control.integral_gain), []
    each = round(TICK / step)
    for row in range(each * (len(motion) - 1)):
        at = row * step / TICK
        lower, share = int(at), at - int(at)
        position, velocity = (
            values[lower] + share * (values[lower + 1] - values[lower])
            for values in (motion.position, motion.velocity)
        )
        error = control.feed_forward * velocity - data.qvel
        error += control.position_gain * (position - data.qpos)
        data.ctrl[:] = control.velocity_gain * (error + control.integral_gain * integral)
        integral = integral + step * error
        mujoco.mj_step(made, data)
        if (row + 1) % each == 0:
            seen.append(data.qpos.copy())
    return np.array(seen)


def test_steps_follow_those_of_our_own_simulation(attached):
    model = arm(StribeckFriction(), LoadDependentFriction(), Hysteresis())
    made, data = compiled(model)
    motion = two_joints.trajectory(10.0).at(np.arange(0.0, 1.5, TICK))
    control = DriveControl.tuned(np.array([2.0, 0.5]), 8.0, np.full(2, np.inf))
    ours = in_plant(model, control, motion)
    far = [np.abs(in_mujoco(made, data, control, motion, TICK / 4) - ours).max()]
    effects = attached(made, data, model)
    far += [np.abs(in_mujoco(made, data, control, motion, step) - ours).max() for step in (TICK / 4, FINE)]
    # without them far off; with them by what a step's length leaves, half of it with half the step
    assert far[1] < 0.1 * far[0]
    assert far[2] < 0.6 * far[1]
    effects.detach()


def test_only_its_own_model_is_changed_and_only_until_detached(attached):
    model = arm(StribeckFriction())
    made, data = compiled(model)
    before = made.dof_frictionloss.copy()
    effects = attached(made, data, model)
    assert not made.dof_frictionloss.any()
    other = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")  # compiled and stepped meanwhile
    mujoco.mj_step(other, mujoco.MjData(other))
    second, its = compiled(arm())
    free, beside = two_joints_moved(second, its), attached(second, its, arm())
    assert beside.effects == ("coulomb_friction",)
    assert np.abs(two_joints_moved(second, its) - free).max() > 0.0
    beside.detach()
    effects.detach()
    assert made.dof_frictionloss.tolist() == before.tolist()
    assert two_joints_moved(second, its).tolist() == free.tolist()


def two_joints_moved(made, data, steps=100):
    mujoco.mj_resetData(made, data)
    data.qvel[:] = 1.0, -1.0
    mujoco.mj_step(made, data, steps)
    return data.qpos.copy()


def test_every_data_of_the_model_has_them_in_rollouts_and_after_a_reset_too(attached):
    rollout = pytest.importorskip("mujoco.rollout")
    model = arm(Hysteresis())
    made, data = compiled(model)
    attached(made, data, model)
    first = two_joints_moved(made, data)
    assert two_joints_moved(made, data).tolist() == first.tolist()
    start = np.zeros(mujoco.mj_stateSize(made, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    start[1 + made.nq : 1 + made.nq + 2] = 1.0, -1.0
    threads = [mujoco.MjData(made) for _ in range(2)]
    states, _ = rollout.rollout(made, threads, np.tile(start, (4, 1)), np.zeros((4, 100, made.nu)))
    assert states[:, -1, 1:3].tolist() == [first.tolist()] * 4


def test_friction_holds_what_it_can_hold(attached):
    model = arm(StribeckFriction())
    made, data = compiled(model)
    attached(made, data, model)
    made.opt.gravity[:] = 0.0
    data.ctrl[:] = -made.actuator_biasprm[:, 0] / made.actuator_gainprm[:, 0] + [3.0, 1.5]  # of 7 and 5 N m
    mujoco.mj_step(made, data, 1000)
    assert np.all(np.abs(data.qvel) < 0.003)


def test_what_cannot_be_attached_is_refused(attached):
    model = arm(StribeckFriction())
    made, data = compiled(model)
    made.dof_damping[0] += 1.0
    with pytest.raises(
        RobotError, match=r"damping of joint 'shoulder' is 4 in MuJoCo, not 3. Write the estimates"
    ):
        attached(made, data, model)
    made.dof_damping[0] -= 1.0
    coupled = arm(KinematicCoupling("elbow", "shoulder"))
    with pytest.raises(RobotError, match="kinematic_coupling depends on acceleration across joints"):
        attached(*compiled(coupled), coupled)
    with pytest.raises(RobotError, match=r"to mujoco.MjModel and MjData, not to types.SimpleNamespace: MJX"):
        attached(SimpleNamespace(), data, model)
    remembers = arm(Hysteresis())
    tried, its = compiled(remembers)
    tried.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(RobotError, match="hysteresis depends on past positions, and RK4"):
        attached(tried, its, remembers)
    attached(made, data, model)
    with pytest.raises(RobotError, match="already has effects attached"):
        attached(made, data, model)


def test_callbacks_of_somebody_else_are_left_alone():
    made, data = compiled(arm())
    mujoco.set_mjcb_control(lambda model, data: None)
    try:
        with pytest.raises(RobotError, match="mjcb_control is in use by another function"):
            Attached(made, data, arm())
        assert mujoco.get_mjcb_passive() is None
    finally:
        mujoco.set_mjcb_control(None)


def test_findings_that_no_model_holds_are_told(tmp_path):
    model = arm(StribeckFriction())
    made, data = compiled(model)
    (tmp_path / "found.toml").write_text(
        model_text(model) + "\n" + findings_text([FindingRow("backlash", ("elbow",), 0.99, False)])
    )
    with pytest.warns(RobotWarning, match=r"not attached because no model can hold it: backlash"):
        effects = attach(made, data, tmp_path / "found.toml")
    assert effects.effects == ("coulomb_friction", "stribeck_friction")
    effects.detach()


def test_threads_of_a_rollout_each_have_their_own_memory(attached):
    rollout = pytest.importorskip("mujoco.rollout")
    model = arm(Hysteresis(), StribeckFriction())
    made, data = compiled(model)
    attached(made, data, model)
    start = np.zeros((6, mujoco.mj_stateSize(made, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    start[:, 1 + made.nq : 1 + made.nq + 2] = np.linspace(-2.0, 2.0, 12).reshape(6, 2)
    threads = [mujoco.MjData(made) for _ in range(3)]
    together, _ = rollout.rollout(made, threads, start, np.zeros((6, 150, made.nu)))
    alone = [rollout.rollout(made, [data], one[None], np.zeros((1, 150, made.nu)))[0][0] for one in start]
    assert together.tolist() == np.array(alone).tolist()


def test_steps_of_a_gymnasium_environment_have_them(attached, tmp_path):
    """A public environment with the file of the arm: its steps are those of MuJoCo with the effects."""
    gymnasium = pytest.importorskip("gymnasium")
    environments = pytest.importorskip("gymnasium.envs.mujoco")
    model = arm(StribeckFriction(), Hysteresis())
    made, data = compiled(model)
    mujoco.mj_saveLastXML(str(tmp_path / "arm.xml"), made)

    class Reaching(environments.MujocoEnv):
        metadata = {"render_modes": ["human", "rgb_array", "depth_array", "rgbd_tuple"]}  # noqa: RUF012

        def __init__(self):
            place = gymnasium.spaces.Box(-np.inf, np.inf, (made.nq,))
            self.metadata["render_fps"] = round(1.0 / (5 * made.opt.timestep))
            super().__init__(str(tmp_path / "arm.xml"), 5, place)

        def reset_model(self):
            self.set_state(self.init_qpos, np.array([1.0, -1.0]))
            return self.data.qpos.copy()

        def step(self, action):
            self.do_simulation(action, self.frame_skip)
            return self.data.qpos.copy(), 0.0, False, False, {}

    environment = Reaching()
    action = 0.1 * np.ones(environment.action_space.shape)
    paths = []
    for effects in (True, False):
        one = attached(environment.unwrapped.model, environment.unwrapped.data, model) if effects else None
        environment.reset(seed=0)
        paths.append(np.array([environment.step(action)[0] for _ in range(40)]))
        if one is not None:
            one.detach()
    environment.close()
    attached(made, data, model)
    data.qvel[:], data.ctrl[:] = (1.0, -1.0), action
    expected = []
    for _ in range(40):
        mujoco.mj_step(made, data, 5)
        expected.append(data.qpos.copy())
    np.testing.assert_allclose(paths[0], expected, rtol=0.0, atol=1e-9)
    assert np.abs(paths[1] - expected).max() > 1e-3
