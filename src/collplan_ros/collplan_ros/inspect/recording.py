"""A recording of any robot: its poses, scans, commands and static transforms, found by type and rate."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mcap.records import Channel, Message, Schema
from mcap.well_known import Profile
from mcap.writer import Writer
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.rosbag1 import ReaderError as Ros1Error
from rosbags.rosbag2 import ReaderError as Ros2Error
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from collplan_core.calibration.frame_chain import Link
from collplan_core.parameters import Mocap
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.reading import NANOSECONDS, place_fields
from collplan_ros.run.reader import is_whole, records
from collplan_ros.run.writer import RECORDING

MCAP = ".mcap"
SCAN, TRANSFORMS = "LaserScan", "/tf_static"
COMMANDS = ("Twist", "TwistStamped")
EXPECTED = "a ROS 1 bag, a ROS 2 bag (folder, .mcap or .db3), or a run folder"


class RecordingError(ValueError):
    """A recording that cannot be used; the message names the file and what was expected."""


@dataclass(frozen=True)
class Topics:
    """Names of the topics: those told, or found; "" where there is none."""

    poses: str = ""
    scans: str = ""
    commands: str = ""


@dataclass(frozen=True, eq=False)
class Recording:
    """What a recording holds, in the order of receipt: times of it [s] and messages."""

    name: str  # of its file or folder
    topics: Topics
    format: str  # of the poses, as `mocap.format`
    duration: float  # [s]
    poses: list[tuple[float, Any]] = field(default_factory=list)
    scans: list[tuple[float, Any]] = field(default_factory=list)
    commands: list[tuple[float, Any]] = field(default_factory=list)
    links: dict[str, Link] = field(default_factory=dict)  # each frame in its parent, of /tf_static
    is_cut: bool = False  # as where its recorder was killed


def read_recording(path: Path, told: Topics, given: Mocap, said: Callable[[float], None]) -> Recording:
    """Reads a recording, a file or folder; `said` takes the share of the messages that is read.

    The user names the topics `told`; those of poses must be of a type of `mocap_formats`. The topic of `given` is taken
    where the recording has it.

    Raises:
        RecordingError: it cannot be read, lacks a topic that is told, or has neither poses nor scans.
    """
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder, expected {EXPECTED}")
    try:
        with TemporaryDirectory() as copies:
            files = _files(path)
            cut = [each for each in files if each.suffix == MCAP and not is_whole(each)]
            whole = [_whole_copy(each, Path(copies)) if each in cut else each for each in files]
            with AnyReader(whole, default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
                return replace(_read(reader, path, told, given, said), is_cut=bool(cut))
    except RecordingError:
        raise
    except (AnyReaderError, Ros1Error, Ros2Error, SerdeError, OSError) as error:
        raise RecordingError(f"{path}: cannot be read: {error}; expected {EXPECTED}") from None
    except Exception as error:  # whatever the library makes of bytes that are no recording
        raise RecordingError(f"{path}: {type(error).__name__}: {error}; expected {EXPECTED}") from None


def _files(path: Path) -> Sequence[Path]:
    """The recording of a run folder; the files of a bag that lacks metadata.yaml, as its recorder was killed."""
    if (path / RECORDING).is_file():
        return [path / RECORDING]
    within = [] if (path / "metadata.yaml").exists() else sorted([*path.glob(f"*{MCAP}"), *path.glob("*.db3")])
    return within or [path]


def _whole_copy(cut: Path, folder: Path) -> Path:
    """A file that has an end, with what one that is cut off holds up to there."""
    channels, schemas = dict[int, int](), dict[int, int]()
    with cut.open("rb") as source, (folder / cut.name).open("wb") as target:
        writer = Writer(target)
        writer.start(profile=Profile.ROS2)
        for each in records(source):
            if isinstance(each, Schema) and each.id not in schemas:
                schemas[each.id] = writer.register_schema(each.name, each.encoding, each.data)
            elif isinstance(each, Channel) and each.id not in channels and each.schema_id in schemas:
                about = each.message_encoding, schemas[each.schema_id], each.metadata
                channels[each.id] = writer.register_channel(each.topic, *about)
            elif isinstance(each, Message) and each.channel_id in channels:
                times = each.publish_time, each.sequence
                writer.add_message(channels[each.channel_id], each.log_time, each.data, *times)
        writer.finish()
    return folder / cut.name


def _read(reader: AnyReader, file: Path, told: Topics, given: Mocap, said: Callable[[float], None]) -> Recording:
    kinds = {name: (each.msgtype or "").rsplit("/", 1)[-1] for name, each in reader.topics.items()}
    counts = {name: each.msgcount for name, each in reader.topics.items()}
    formats = {each.message: name for name, each in FORMATS.items() if not each.several or given.subject}
    topics = Topics(
        _named("poses", told.poses, kinds, formats, counts, given.topic),
        _named("scans", told.scans, kinds, (SCAN,), counts, "scan"),
        _named("commands", told.commands, kinds, COMMANDS, counts, "cmd_vel"),
    )
    if not (topics.poses or topics.scans):
        found = ", ".join(f"{name} ({kind})" for name, kind in kinds.items()) or "no topic"
        raise RecordingError(f"{file}: found {found}, expected poses ({', '.join(formats)}) or scans ({SCAN})")
    form, duration = formats.get(kinds.get(topics.poses, ""), given.format), max(reader.duration / NANOSECONDS, 1e-3)
    taken = Recording(file.name, topics, form, duration)
    rows = {topics.poses: taken.poses, topics.scans: taken.scans, topics.commands: taken.commands}
    wanted = [each for each in reader.connections if each.topic in rows or each.topic.endswith(TRANSFORMS)]
    total = max(sum(each.msgcount for each in wanted), 1)
    for at, (connection, received, raw) in enumerate(reader.messages(wanted)):
        message = reader.deserialize(raw, connection.msgtype)
        if connection.topic in rows:
            rows[connection.topic].append((received / NANOSECONDS, message))
        else:
            _keep_links(taken.links, message)
        if at % 500 == 0:
            said(at / total)
    if not (taken.poses or taken.scans):
        raise RecordingError(f"{file}: holds no message of {topics.poses or topics.scans}, expected some")
    return taken


def _named(what: str, told: str, kinds: Mapping[str, str], types: Any, counts: Mapping[str, int], usual: str) -> str:
    """The topic told, the usual one, or that of the most messages of these types, in their order; "" without one."""
    if told:
        if kinds.get(told) not in types:
            got = f"is of type {kinds[told]}" if told in kinds else "is not in the recording"
            raise RecordingError(f"{what}: {told} {got}, expected a topic of {', '.join(types)}")
        return told
    fitting = [name for name, kind in kinds.items() if kind in types and counts[name]]
    usually = [name for name in fitting if f"/{name}".endswith(f"/{usual}")]
    # a motion capture's pose goes before odometry, which a robot may publish beside it
    order = list(types)
    return min(usually or fitting, key=lambda name: (order.index(kinds[name]), -counts[name]), default="")


def _keep_links(links: dict[str, Link], message: Any) -> None:
    for each in message.transforms:
        links[each.child_frame_id] = Link(
            each.header.frame_id, *place_fields(each.transform.translation, each.transform.rotation)
        )
