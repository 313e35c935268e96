"""A third planner, as small as one can be: straight to the goal, whatever stands in the way."""

from collplan_core.planners import Planner
from straight_planner.plan_cycle import plan_cycle

STRAIGHT = Planner(
    plan_cycle,
    map_period=0.1,
)
