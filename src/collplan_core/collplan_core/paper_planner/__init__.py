"""The planner of Lu, Liu, Correa and Karydis: candidates on frontiers, weighed by the risk and reward of touching."""
