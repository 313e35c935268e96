"""The seed of a trial."""

from hashlib import sha256


def trial_seed(study_seed: int, world: str, trial: int) -> int:
    """31-bit seed of a trial. It depends on neither strategy nor parameters, so that these are compared at equal noise.

    Args:
        study_seed: seed of the whole study.
        world: name of the world.
        trial: number of the trial in its cell.
    """
    digest = sha256(f"{study_seed}/{world}/{trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1
