"""The seed of a trial."""

from hashlib import sha256


def trial_seed(study_seed: int, world: str, trial: int) -> int:
    """31-bit seed from the study's seed, the world's name and the trial's number alone: strategies meet equal noise."""
    digest = sha256(f"{study_seed}/{world}/{trial}".encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1
