"""The paper's three strategies as weight sets. Paper: IV-B."""

from collplan_core.params import Settings, Weights

STRATEGIES: dict[str, Weights] = {
    "harness": Weights(position=100.0, risk=0.1, velocity=4.0),
    "high_risk": Weights(position=100.0, risk=0.1, velocity=0.0),
    "low_risk": Weights(position=100.0, risk=100.0, velocity=0.0),
}


def weights_of(settings: Settings) -> Weights:
    """The weights of the chosen strategy; `custom` takes the weights group as it stands."""
    return STRATEGIES.get(settings.planner.strategy, settings.weights)
