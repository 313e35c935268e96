"""Reads run.mcap, also one that was cut off: the description of the run, and its messages in the order of receipt."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, McapRecord, Metadata, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.well_known import MessageEncoding
from mcap_ros2.decoder import DecoderFactory

from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.run.description import RUN
from collplan_ros.run.whole_file import RunError

MAGIC = b"\x89MCAP0\r\n"
"""Bytes at the beginning and end of a file in the MCAP format."""
POSES = "/mocap/odom"
"""End of the name of the topic that every run has."""
SHORTEST = 2 * len(MAGIC) + 29
"""Size of a file that has an end [bytes]: both marks and a footer."""


class Message(NamedTuple):
    """A message as it was sent."""

    topic: str  # as it was requested
    kind: str  # its type, such as nav_msgs/msg/Odometry
    data: bytes  # CDR with its header, as rclpy deserialises it
    came: int  # when the recorder received it [ns, wall clock at the begin of the recording, continued]
    sent: int  # [ns, the same clock]
    number: int  # among its publisher's messages, from 1; 0 where that is unknown
    decode: Callable[[bytes], Any]

    @property
    def decoded(self) -> Any:
        """The message; it has the fields of ROS's own, and needs no ROS."""
        return self.decode(self.data)

    @property
    def content(self) -> Any:
        """The message, or its bytes on a topic of BYTES_TOPICS; None where it cannot be decoded."""
        if self.topic in BYTES_TOPICS:
            return self.data
        try:
            return self.decoded
        except Exception:  # whatever the library makes of bytes that are no message
            return None


def entries(path: Path, topics: Sequence[str]) -> Iterator[Metadata | Message]:
    """Yields the descriptions of a run and the messages of `topics`, in the order of recording.

    A topic is given as its node names it, `plan` for `/robot1/plan` where that is the robot's namespace. Of a file that
    was cut off everything up to there is read. RunError: the file is missing, or is no recording.
    """
    namespace, schemas = namespace_of(path).rstrip("/"), dict[int, Schema]()
    channels: dict[int, tuple[str, str, Callable[[bytes], Any]]] = {}
    factory = DecoderFactory()
    for record in _records_of(path):
        if isinstance(record, McapMessage):
            if record.channel_id in channels:
                topic, kind, decode = channels[record.channel_id]
                times = record.log_time, record.publish_time
                yield Message(topic, kind, record.data, *times, record.sequence, decode)
        elif isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            asked = {topic if topic.startswith("/") else f"{namespace}/{topic}": topic for topic in topics}
            if record.topic in asked and record.id not in channels:
                schema = schemas.get(record.schema_id)
                decode = factory.decoder_for(MessageEncoding.CDR, schema) or _unknown
                channels[record.id] = asked[record.topic], schema.name if schema else "", decode
        elif isinstance(record, Metadata):
            yield record


def namespace_of(path: Path) -> str:
    """The namespace of a robot's nodes, by its poses where no description tells it; RunError as of `entries`."""
    told = description(path, RUN)
    if told:
        return told.get("namespace", "/")
    topics = (each.topic for each in _records_of(path) if isinstance(each, Channel))
    return next((topic.removesuffix(POSES) for topic in topics if topic.endswith(POSES)), "") or "/"


def raw_messages(path: Path, topics: Sequence[str]) -> Iterator[Message]:
    """The messages of `topics`, as `entries` gives them; RunError as of `entries`."""
    return (entry for entry in entries(path, topics) if isinstance(entry, Message))


def messages(path: Path, topics: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
    """Yields the same, decoded: topic, time of receipt [ns], and the message; RunError as of `entries`."""
    return ((each.topic, each.came, each.decoded) for each in raw_messages(path, topics))


def attachment(path: Path, name: str) -> str:
    """The text attached to a recording under this name; RunError where there is none, and as of `entries`."""
    for record in _records_of(path):
        if isinstance(record, Attachment) and record.name == name:
            return record.data.decode()
    raise RunError(f"{path}: nothing attached as {name!r}")


def description(path: Path, name: str) -> dict[str, str]:
    """A recording's description of its run or the code, by name; empty where it has none; RunError as of `entries`."""
    found = (each for each in _records_of(path) if isinstance(each, Metadata) and each.name == name)
    return next((dict(each.metadata) for each in found), {})


def is_whole(path: Path) -> bool:
    """Whether a recording has an end; one whose bringup was killed has none; RunError: it cannot be read."""
    with _opened(path) as file:
        if file.seek(0, 2) < SHORTEST:
            return False
        file.seek(-len(MAGIC), 2)
        return file.read() == MAGIC


def records(file: BinaryIO) -> Iterator[McapRecord]:
    """The records up to where the file is cut off, those of a chunk one by one, and the chunk itself after them.

    A chunk that the disk has changed is left out: the next one may be as it was written.
    """
    reader = StreamReader(file, emit_chunks=True, record_size_limit=file.seek(0, 2)).records
    file.seek(0)
    while True:
        try:
            record = next(reader, None)
        except OSError:
            raise
        except Exception:  # whatever the library makes of half a record, or of what is none
            return
        if record is None or isinstance(record, DataEnd):
            return
        if isinstance(record, Chunk):
            yield from _whole_chunk(record)
        # outside a chunk nothing protects the others
        if isinstance(record, Header | Attachment | Metadata | Chunk):
            yield record


def _whole_chunk(chunk: Chunk) -> list[McapRecord]:
    """The records of a chunk; none where its checksum does not fit."""
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except Exception:  # of a library that takes it for what was written
        return []


def _records_of(path: Path) -> Iterator[McapRecord]:
    with _opened(path) as file:
        found = records(file)
        if not isinstance(next(found, None), Header):
            raise RunError(f"{path}: expected a recording that bringup wrote, in the MCAP format")
        yield from found


def _unknown(_: bytes) -> Any:
    raise ValueError("the definition of this message is not in the recording")


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    try:
        with path.open("rb") as file:
            yield file
    except OSError as error:
        raise RunError(f"{path}: cannot be read: {error.strerror or error}") from None
