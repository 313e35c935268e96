"""What lines do to frames."""

import random


def damaged(stream: bytes, random_: random.Random) -> bytes:
    """One frame with what lines do to frames: flipped bits, bytes lost, doubled, put in, or the end cut off."""
    data = bytearray(stream)
    kind = random_.randrange(5)
    at = random_.randrange(len(data))
    if kind == 0:
        for _ in range(random_.randint(1, 8)):
            data[random_.randrange(len(data))] ^= 1 << random_.randrange(8)
    elif kind == 1:
        del data[at : at + random_.randint(1, 4)]
    elif kind == 2:
        data[at:at] = data[at : at + random_.randint(1, 4)]
    elif kind == 3:
        data[at:at] = random_.randbytes(random_.randint(1, 6))
    else:
        del data[at:]
    return bytes(data)
