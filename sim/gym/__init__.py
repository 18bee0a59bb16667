"""The spacecraft as Gymnasium environments.

`Spacecraft-Attitude-v0` (wheel torques) and `Spacecraft-Operations-v0` (telecommands, goals as reward). Gymnasium finds
them by the entry point `gymnasium.envs`; without an installed package, `gymnasium.make("sim.gym:Spacecraft-...")` or a
call of `register` brings them in. Gymnasium is only imported by the modules of the environments themselves, so that its
own start may load this one.
"""

from __future__ import annotations

ATTITUDE = "Spacecraft-Attitude-v0"
OPERATIONS = "Spacecraft-Operations-v0"


def register() -> None:
    """Enter both environments into Gymnasium's registry, once."""
    from gymnasium.envs import registration

    if ATTITUDE not in registration.registry:
        registration.register(ATTITUDE, entry_point="sim.gym.attitude:AttitudeEnvironment", max_episode_steps=600)
    if OPERATIONS not in registration.registry:
        registration.register(OPERATIONS, entry_point="sim.gym.operations:OperationsEnvironment")
