import gc
import importlib
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from sim import ConfigurationError, RenderingUnavailable, SpacecraftConfig
from sim.components.wheels import SPEEDS
from sim.dictionary import TELECOMMANDS
from sim.gym import ATTITUDE, OPERATIONS, register
from sim.gym.attitude import RATE_BOUND_RAD_S, AttitudeEnvironment
from sim.gym.operations import GOALS, OperationsEnvironment
from sim.offscreen import find_backend

register()
IDS = (ATTITUDE, OPERATIONS)


def rendering_works():
    try:
        find_backend()
    except RenderingUnavailable:
        return False
    return True


def make(name):
    """Short enough steps and episodes that thousands of them take seconds."""
    if name == ATTITUDE:
        return gymnasium.make(name, seconds_per_step=1)
    return gymnasium.make(name, seconds_per_step=2, horizon_s=600)


def trace(env, seed, actions):
    """All that an episode gives, until it ends or the actions do."""
    observation, info = env.reset(seed=seed)
    seen = [(observation.tobytes(), 0.0, False, False, repr(info))]
    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        seen.append((observation.tobytes(), reward, terminated, truncated, repr(info)))
        if terminated or truncated:
            break
    return seen


def actions_of(env, seed, count):
    env.action_space.seed(seed)
    return [env.action_space.sample() for _ in range(count)]


@pytest.mark.parametrize("name", IDS)
def test_the_checker_of_gymnasium_is_content(name):
    render_mode = "rgb_array" if rendering_works() else None
    env = gymnasium.make(name, render_mode=render_mode).unwrapped
    check_env(env, skip_render_check=render_mode is None)
    env.close()


@pytest.mark.parametrize("name", IDS)
def test_registering_again_changes_nothing(name):
    before = gymnasium.spec(name)
    register()
    assert gymnasium.spec(name) is before
    module, _, attribute = str(before.entry_point).partition(":")
    assert issubclass(getattr(importlib.import_module(module), attribute), gymnasium.Env)


@pytest.mark.parametrize("name", IDS)
def test_ten_thousand_random_steps_with_resets_at_every_kind_of_moment(name):
    """Random resets, resets right after a reset, after an end and in the midst; everything stays in its space."""
    env = make(name)
    generator = np.random.default_rng(5)
    env.action_space.seed(5)
    observation, _ = env.reset(seed=5)
    kinds = {"ended": 0, "midst": 0, "twice": 0, "seeded": 0}
    ended = False
    for _ in range(10_000):
        assert env.observation_space.contains(observation)
        chance = generator.random()
        if ended:
            kinds["ended"] += 1
            observation, _ = env.reset()
        elif chance < 0.002:
            kinds["midst"] += 1
            observation, _ = env.reset()
        elif chance < 0.003:
            kinds["twice"] += 1
            env.reset()
            observation, _ = env.reset()
        elif chance < 0.004:
            kinds["seeded"] += 1
            observation, _ = env.reset(seed=int(generator.integers(100)))
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        assert np.isfinite(reward)
        ended = terminated or truncated
    assert min(kinds.values()) >= 3, kinds
    env.close()


@pytest.mark.parametrize("name", IDS)
def test_an_episode_depends_on_its_seed_and_actions_alone(name):
    fresh, used = make(name), make(name)
    actions = actions_of(fresh, 3, 250)
    expected = trace(fresh, 11, actions)
    trace(used, 4, actions_of(used, 8, 150))
    trace(used, 5, [])
    assert trace(used, 11, actions) == expected
    assert trace(used, 11, actions) == expected, "once more in the same environment"
    assert trace(used, 12, actions) != expected
    for env in (fresh, used):
        env.close()


@pytest.mark.parametrize("name", IDS)
def test_a_vector_of_environments_flies_like_each_alone(name):
    vector = gymnasium.make_vec(name, num_envs=3, vectorization_mode="sync")
    observations, _ = vector.reset(seed=[1, 2, 3])
    alone = gymnasium.make(name)
    actions = [np.array(actions_of(alone, seed, 10)) for seed in (7, 8, 9)]
    seen = [observations]
    for step in range(10):
        observations, rewards, *_ = vector.step(np.array([row[step] for row in actions]))
        assert np.isfinite(rewards).all()
        seen.append(observations)
    for place, seed in enumerate((1, 2, 3)):
        expected = [row[0] for row in trace(alone, seed, actions[place])]
        assert [row[place].tobytes() for row in seen] == expected
    vector.close()
    alone.close()


def test_the_science_camera_can_be_the_picture():
    env = gymnasium.make("Spacecraft-Operations-v0", render_mode="rgb_array", camera="micas")
    env.reset(seed=1)
    craft = env.unwrapped._craft
    assert np.array_equal(env.render(), craft.render("micas", 256, 256))
    with pytest.raises(ConfigurationError, match="camera: expected one of micas, chase, found 'selfie'"):
        gymnasium.make("Spacecraft-Operations-v0", camera="selfie")
    env.close()


@pytest.mark.gl
@pytest.mark.parametrize("name", IDS)
def test_pictures_are_rgb_and_show_something(name):
    if not rendering_works():
        pytest.skip("no offscreen OpenGL here")
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=1)
    frame = env.render()
    assert (frame.shape, frame.dtype) == ((256, 256, 3), np.uint8)
    assert frame.std() > 5.0
    env.reset(seed=2)
    assert env.render().shape == (256, 256, 3)
    env.close()


@pytest.mark.parametrize("name", IDS)
def test_spaces_are_bounded(name):
    env = gymnasium.make(name)
    assert np.isfinite(env.observation_space.low).all()
    assert np.isfinite(env.observation_space.high).all()


def test_a_plain_law_reaches_the_target_and_is_rewarded():
    env = AttitudeEnvironment(seconds_per_step=1)
    observation, info = env.reset(seed=1, options={"angle_rad": 0.3})
    assert info["error_rad"] == pytest.approx(0.3)
    axes = np.array(env._assembly.wheel_axes_B)
    terminated, reward = False, 0.0
    for _ in range(1500):
        error, rate = observation[1:4] * 2.0, observation[4:7] * RATE_BOUND_RAD_S
        torque_B = 400.0 * (-0.0025 * error - 0.09 * rate)
        action = (-0.75 * axes @ torque_B / 0.2).astype(np.float32)
        observation, reward, terminated, truncated, info = env.step(np.clip(action, -1, 1))
        assert not truncated
        if terminated:
            break
    assert terminated
    assert reward > 99.0
    assert info["error_rad"] < 5e-4
    assert info["held_s"] >= 60
    _, info = env.reset(seed=2)
    assert info["held_s"] == 0
    speeds = env._wheels.memory[SPEEDS : SPEEDS + 4].tolist()
    assert speeds == env._flying().wheel_speeds_rad_s, "the wheels of the new episode, not of the old one"


def test_tumbling_ends_an_episode_badly():
    env = AttitudeEnvironment(seconds_per_step=20)
    env.reset(seed=1)
    push = np.array([1, 1, -1, -1], dtype=np.float32)
    rewards, ended = [], False
    while not ended:
        observation, reward, ended, _, info = env.step(push)
        assert env.observation_space.contains(observation), "also the one that ends it, beyond the bound"
        rewards.append(reward)
        assert len(rewards) < 60, info
    assert rewards[-1] < -99.0


def test_goals_that_come_true_are_rewarded_once():
    config = SpacecraftConfig(engine_start_s=(5.0, 6.0), camera_warmup_s=(5.0, 6.0), camera_readout_s=(5.0, 6.0))
    env = OperationsEnvironment(config=config, seconds_per_step=60, horizon_s=43_200)
    env.reset(seed=3)
    assert tuple(goal.kind for goal in env.goals) == GOALS
    number = {(c[0], *c[1].values()): k for k, c in enumerate(env.commands) if c is not None}
    wait, total, terminated = 0, 0.0, False

    def do(*command, seconds=60):
        nonlocal total, terminated
        for k in range(max(1, seconds // 60)):
            _, reward, terminated, _, info = env.step(number[command] if command and k == 0 else wait)
            total += reward
            assert info["accepted"], command

    do("micas.power", True)
    do("ips.start")
    for goal in sorted((g for g in env.goals if g.kind != "downlink"), key=lambda goal: goal.start_s):
        gap = int(goal.start_s - env._flying().time)
        do(seconds=gap)
        do("acs.point", goal.target, seconds=2400)
        if goal.kind == "image":
            do("micas.expose", goal.target, 30.0, seconds=120)
            do("micas.expose", goal.target, 30.0, seconds=120)
        else:
            do("ips.thrust", 48, seconds=int(goal.amount) + 120)
            do("ips.idle")
    achieved = sum(goal.achieved for goal in env.goals)
    assert achieved >= 2
    credit = sum(goal.done / goal.amount for goal in env.goals)
    assert total == pytest.approx(achieved + credit)


def test_a_refused_command_costs_a_little_and_does_nothing():
    env = OperationsEnvironment()
    env.reset(seed=1)
    number = next(k for k, c in enumerate(env.commands) if c is not None and c[0] == "ips.idle")
    _, reward, _, _, info = env.step(number)
    assert (reward, info["accepted"]) == (-0.01, False)


def test_every_telecommand_is_an_action():
    env = OperationsEnvironment()
    assert {c[0] for c in env.commands if c is not None} == set(TELECOMMANDS)
    assert env.commands[0] is None


@pytest.mark.parametrize("kind", [AttitudeEnvironment, OperationsEnvironment])
def test_wrong_use_says_what_was_expected(kind):
    with pytest.raises(ConfigurationError, match="render_mode: expected rgb_array"):
        kind(render_mode="human")
    with pytest.raises(ConfigurationError, match="seconds_per_step"):
        kind(seconds_per_step=0)
    env = kind()
    with pytest.raises(ConfigurationError, match="expected a reset"):
        env.step(env.action_space.sample())
    with pytest.raises(ConfigurationError, match="reset options"):
        env.reset(options={"angel": 1.0})


def test_resets_leave_no_memory_behind():
    env = make(OPERATIONS)

    def blocks_after(resets):
        for seed in range(resets):
            env.reset(seed=seed)
        gc.collect()
        return sys.getallocatedblocks()

    before = blocks_after(60)
    grown = blocks_after(300) - before
    assert grown < 2 * 300, "objects of each reset stay"
