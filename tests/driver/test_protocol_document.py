"""The worked examples of docs/protocol.md are what the code makes and reads."""

import re
from pathlib import Path

from omnipuck_driver.codec import Decoder
from omnipuck_driver.framing import VERSION, Frame, pack_frame, unpack_frame
from omnipuck_driver.messages import NO_TEMPERATURE, Announce, CommandMessage, Hello, Telemetry, WheelCaps

DOCUMENT = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
EXAMPLES = [bytes.fromhex(row) for row in re.findall(r"^\| .* \| `(00(?: [0-9a-f]{2})+)` \|$", DOCUMENT, re.MULTILINE)]
BEFORE = 1000, 5, 25, 3, 1, 2, 300
MEANT = [
    (7, Hello(42, WheelCaps(70.5, 500.0))),
    (8, CommandMessage(42, 1000, 20, 180, 0, 0, 1, (-25.0, 0.0, 25.0))),
    (9, CommandMessage(42, 1020, 0, 200, 1, 0, 1, (0.0, 0.0, 0.0))),
    (10, CommandMessage(42, 1040, 0, 200, 2, 1, 1, (0.0, 0.0, 0.0))),
    (0, Announce(42, 7, 1, 3, 500, WheelCaps(70.5, 500.0), "puck 2.0")),
    (1, Telemetry(42, 7, 5000, 1, 7400, NO_TEMPERATURE, *BEFORE, (-0.5, 0.25), 0, 1, (-24.0, 0.0, 24.0))),
]


def test_the_examples_are_what_the_code_makes():
    assert [pack_frame(Frame(VERSION, message.KIND, number, message.pack())) for number, message in MEANT] == EXAMPLES


def test_the_examples_are_what_the_code_reads():
    assert [Decoder().feed(example) for example in EXAMPLES] == [[message] for _, message in MEANT]
    assert [unpack_frame(example[1:-1]).sequence for example in EXAMPLES] == [number for number, _ in MEANT]


def test_the_tables_have_the_sizes_of_the_code():
    sizes = {"u8": 1, "u16": 2, "i16": 2, "u32": 4, "f32": 4}
    for number, message in MEANT:
        (payload,) = re.findall(rf"^\| {message.KIND:02x} \| \w+ \| (.*) \|$", DOCUMENT, re.MULTILINE)
        fixed, *wheels = payload.split(", n x wheel f32")
        length = sum(sizes[kind] for kind in re.findall(r"\b(u8|u16|i16|u32|f32)\b", fixed))
        length += 12 if "12 x ASCII" in fixed else 0
        assert length + (4 * len(message.wheels) if wheels else 0) == len(message.pack()), number
