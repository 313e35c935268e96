"""The planner that minimises the time to the goal over rollouts, with contacts foreseen and priced."""
