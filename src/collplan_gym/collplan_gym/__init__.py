"""The simulated robot as an environment of gymnasium; importing this registers `collplan/Bounce-v0`.

    import gymnasium
    import collplan_gym
    env = gymnasium.make("collplan/Bounce-v0", world="serpentine:2")

`gymnasium.make_vec("collplan/Bounce-v0", num_envs=4, vectorization_mode="async")` runs four of them in processes.
`PlannerPolicy("bounce")` drives it by a strategy of collplan.
"""

import gymnasium

from collplan_gym.bounce_env import BounceEnv
from collplan_gym.planner_policy import PlannerPolicy

__all__ = ["BounceEnv", "PlannerPolicy"]

gymnasium.register("collplan/Bounce-v0", entry_point=BounceEnv)
