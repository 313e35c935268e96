"""Program for one tree of sources, which PYTHONPATH names: runs trials and says how long they take the processor."""

from time import process_time

from answering import serve

from collplan_core.parameters import Settings
from omnipuck_sim.trial import run_trial


def paces(seed: int, strategy: str, worlds: list[str]) -> list[float]:
    """Processor time a simulated second of a trial in each world [us]."""
    settings, taken = Settings().with_values({"planner.strategy": strategy}), []
    for world in worlds:
        begun = process_time()
        run = run_trial(world, settings, seed)
        taken.append(1e6 * (process_time() - begun) / float(run.trajectory[-1, 0]))
    return taken


if __name__ == "__main__":
    serve({"paces": paces})
