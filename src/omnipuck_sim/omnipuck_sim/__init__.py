"""The simulated Omnipuck; `run_trial` drives it to a goal without ROS and returns a `TrialResult`."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from omnipuck_sim.trial import run_trial
    from omnipuck_sim.trial_record import TrialResult

__all__ = ["TrialResult", "run_trial"]


def __getattr__(name: str) -> Any:
    """Imports a name on first use: the nodes need none of them."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.trial"), name)
