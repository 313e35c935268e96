"""Reading a recording that is whole: messages, and what it says of its run."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from mcap.exceptions import McapError
from mcap.reader import McapReader, NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from collplan_ros.recording.description import RUN
from collplan_ros.runs.run_error import RunError

MAGIC = b"\x89MCAP0\r\n"
"""With what a file in the MCAP format begins and ends."""
SHORTEST = 2 * len(MAGIC) + 29
"""Size of a file that has an end [bytes]: both marks and a footer."""


class Message(NamedTuple):
    """A message as it was sent.

    Attributes:
        topic: as it was asked for.
        kind: its type, such as nav_msgs/msg/Odometry.
        data: CDR with its header, as rclpy deserialises it.
        came: when it came to the recorder [ns, wall clock].
        sent: when it was sent [ns, wall clock].
        number: which of its publisher's messages it is, from 1; 0 where that is not known.
    """

    topic: str
    kind: str
    data: bytes
    came: int
    sent: int
    number: int


def messages(path: Path, topics: Sequence[str]) -> Iterator[tuple[str, int, Any]]:
    """The messages of `topics` in the order in which they came: topic, when it came [ns, wall clock], message.

    The order holds also where the wall clock was set meanwhile.

    A topic is given as its node names it, `plan` for `/robot1/plan` where that is the robot's namespace. A message is
    decoded by the definition in the file; it has the fields of ROS's own, and needs no ROS.

    Raises:
        RunError: the file is missing, is no recording, or is not whole.
    """
    with _opened(path) as file:
        names = _full_names(make_reader(file), topics)
        for _, channel, message, decoded in _as_written(file).iter_decoded_messages(list(names), log_time_order=False):
            yield names[channel.topic], message.log_time, decoded


def raw_messages(path: Path, topics: Sequence[str]) -> Iterator[Message]:
    """The same, not decoded.

    Raises:
        RunError: the file is missing, is no recording, or is not whole.
    """
    with _opened(path) as file:
        names = _full_names(make_reader(file), topics)
        for schema, channel, message in _as_written(file).iter_messages(list(names), log_time_order=False):
            times = message.log_time, message.publish_time
            yield Message(names[channel.topic], schema.name if schema else "", message.data, *times, message.sequence)


def attachment(path: Path, name: str) -> str:
    """What is attached to a recording under this name.

    Raises:
        RunError: there is nothing of this name, or the file is missing, is no recording, or is not whole.
    """
    with _opened(path) as file:
        for each in make_reader(file).iter_attachments():
            if each.name == name:
                return each.data.decode()
    raise RunError(f"{path}: nothing attached as {name!r}")


def description(path: Path, name: str) -> dict[str, str]:
    """What a recording tells of its run, or of the code, by name; empty where it tells nothing.

    Raises:
        RunError: the file is missing, is no recording, or is not whole.
    """
    with _opened(path) as file:
        return _described(make_reader(file), name)


def is_whole(file: BinaryIO) -> bool:
    """Whether a recording has an end; one whose bringup was killed has none."""
    size = file.seek(0, 2)
    if size < SHORTEST:
        return False
    file.seek(-len(MAGIC), 2)
    return file.read() == MAGIC


def _described(reader: McapReader, name: str) -> dict[str, str]:
    return next((dict(each.metadata) for each in reader.iter_metadata() if each.name == name), {})


def _full_names(reader: McapReader, topics: Sequence[str]) -> dict[str, str]:
    """The topics as they were asked for, by their full names."""
    namespace = _described(reader, RUN).get("namespace", "/").rstrip("/")
    return {topic if topic.startswith("/") else f"{namespace}/{topic}": topic for topic in topics}


def _as_written(file: BinaryIO) -> McapReader:
    """A reader of messages in the order of the file: by their times, a wall clock that was set would change it.

    The library's other reader would keep all of them in memory for that.
    """
    file.seek(0)
    return NonSeekingReader(file, decoder_factories=[DecoderFactory()])


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    try:
        with path.open("rb") as file:
            if not is_whole(file):
                raise RunError(f"{path}: has no end, expected a recording that bringup has finished or completed")
            file.seek(0)
            yield file
    except OSError as error:
        raise RunError(f"{path}: cannot be read: {error.strerror or error}") from None
    except McapError as error:
        raise RunError(f"{path}: expected a recording: {error}") from None
