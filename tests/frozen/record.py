"""Keeps a run folder of bringup as a frozen one: `python tests/frozen/record.py NAME RUN_FOLDER`.

Journals, compared candidates and markers, which no result file needs, are left out. The name killed also leaves out the
end of the file. Then call `make frozen`.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from shutil import copy

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from collplan_ros.run.reader import records

FOLDERS = Path(__file__).with_name("runs")
LEFT_OUT = ("/journal", "planner/compared", "planner/markers", "planner/seen", "parameter_events", "clock")


def keep(folder: Path, kept: Path, left_out: Sequence[str] = LEFT_OUT, has_end: bool = True) -> None:
    """Writes the files of a run folder into another one, without the topics whose names have a part of `left_out`."""
    kept.mkdir(parents=True, exist_ok=True)
    copy(folder / "parameters.yaml", kept)
    schemas, channels = dict[int, int](), dict[int, int]()
    with (folder / "run.mcap").open("rb") as source, (kept / "run.mcap").open("wb") as target:
        writer = Writer(target, compression=CompressionType.ZSTD, chunk_size=1 << 16)
        writer.start(profile="ros2", library="collplan")
        for record in records(source):
            if isinstance(record, Schema):
                schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            elif isinstance(record, Channel) and not any(part in record.topic for part in left_out):
                about = record.topic, record.message_encoding, schemas[record.schema_id]
                channels[record.id] = writer.register_channel(*about, record.metadata)
            elif isinstance(record, Message) and record.channel_id in channels:
                times = record.publish_time, record.sequence
                writer.add_message(channels[record.channel_id], record.log_time, record.data, *times)
            elif isinstance(record, Attachment):
                made = record.create_time, record.log_time
                writer.add_attachment(*made, record.name, record.media_type, record.data)
            elif isinstance(record, Metadata):
                writer.flush()
                writer.add_metadata(record.name, record.metadata)
        writer.flush()
        whole = target.tell()
        writer.finish()
    if not has_end:
        with (kept / "run.mcap").open("rb+") as file:
            file.truncate(whole)


if __name__ == "__main__":
    name = sys.argv[1]
    keep(Path(sys.argv[2]), FOLDERS / name, has_end=name != "killed")
