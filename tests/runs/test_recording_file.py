"""run.mcap: every message comes back bit by bit, by two libraries, with what is said of its topic."""

import resource
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability

from collplan_ros.run.reader import attachment, description, messages, raw_messages
from collplan_ros.run.whole_file import RecordError, RunError
from collplan_ros.run.writer import RECORDING, RecordingFile
from made_recordings import EPOCH, POINT, TOPICS, MadeRecording, point, sent


@given(st.lists(sent, max_size=40), st.sets(st.integers(0, 40)))
def test_each_message_comes_back_bit_by_bit_and_both_libraries_decode_it(rows, flushed):
    with tempfile.TemporaryDirectory() as folder:
        made = MadeRecording(Path(folder) / RECORDING)
        for number, row in enumerate(rows):
            made.write(*row)
            if number in flushed:
                made.file.flush()
        made.file.finish()
        read = list(raw_messages(made.path, list(TOPICS)))
        assert [(each.topic, each.came, each.data) for each in read] == made.rows
        assert [(each.kind, each.sent, each.number) for each in read] == [
            (TOPICS[topic], came - 1000, number) for number, (topic, came, _) in enumerate(made.rows, 1)
        ]
        for (topic, original), (name, _, decoded) in zip(rows, messages(made.path, list(TOPICS)), strict=True):
            assert name == topic
            assert_same(topic, original, decoded)
        with AnyReader([made.path]) as reader:
            again = list(reader.messages())
            assert [(connection.topic, came, data) for connection, came, data in again] == made.rows
            for (topic, original), (connection, _, data) in zip(rows, again, strict=True):
                assert_same(topic, original, reader.deserialize(data, connection.msgtype))


def test_messages_come_in_the_order_in_which_they_came_also_where_the_wall_clock_was_set_back(tmp_path):
    for period in (4, 100):
        made = MadeRecording(tmp_path / f"{period}.mcap")
        for number in range(12):
            made.epoch = EPOCH - (1_000_000_000 if number >= 5 else 0)
            made.write("/controller/reference", point(float(number), 0.0))
            if number % period == 1:
                made.file.flush()
        made.file.finish()
        assert [each.came for each in raw_messages(made.path, list(TOPICS))] == [came for _, came, _ in made.rows]
        assert [message.point.x for _, _, message in messages(made.path, list(TOPICS))] == list(range(12))


def assert_same(topic: str, original, decoded) -> None:
    if TOPICS[topic] != POINT:
        assert decoded.data == original.data
        return
    place, header = decoded.point, decoded.header
    assert (place.x, place.y, place.z) == (original.point.x, original.point.y, 0.0)
    assert (header.frame_id, header.stamp.sec, header.stamp.nanosec) == (original.header.frame_id, 12, 345)


def written(path: Path) -> MadeRecording:
    made = MadeRecording(path)
    for number in range(3):
        made.write("/controller/reference", point(float(number), 0.0))
    return made


def test_what_is_said_of_publishers_and_of_the_run_is_read(tmp_path):
    made = written(tmp_path / RECORDING)
    made.file.finish()
    with AnyReader([made.path]) as reader:
        (connection,) = reader.connections
        (offered,) = connection.ext.offered_qos_profiles
    assert (connection.msgtype, connection.ext.serialization_format, connection.msgcount) == (POINT, "cdr", 3)
    assert (offered.reliability, offered.durability) == (QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL)
    assert (offered.history, offered.depth) == (QosHistory.UNKNOWN, 0)
    assert attachment(made.path, "parameters.yaml") == "/**: {}\n"
    assert description(made.path, "run")["goal"] == "1.0 2.0"
    assert description(made.path, "nothing") == {}
    with pytest.raises(RunError, match=r"run.mcap: .*'world.yaml'"):
        attachment(made.path, "world.yaml")


def test_topics_are_asked_for_as_their_nodes_name_them(tmp_path):
    made = MadeRecording(tmp_path / RECORDING, "/robot1")
    made.write("/robot1/controller/reference", point(1.0, 2.0))
    made.write("/controller/reference", point(3.0, 4.0))
    made.file.finish()
    ((topic, came, message),) = messages(made.path, ["controller/reference"])
    assert (topic, came, message.point.x) == ("controller/reference", EPOCH, 1.0)
    assert [each.topic for each in raw_messages(made.path, ["/controller/reference"])] == ["/controller/reference"]
    assert list(messages(made.path, ["reference"])) == []


def test_a_disk_that_is_full_leaves_a_recording_of_what_was_flushed_before(tmp_path):
    made = written(tmp_path / RECORDING)
    made.file.flush()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    made.write("/controller/reference", point(3.0, 0.0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (made.path.stat().st_size + 20, limits[1]))
    try:
        with pytest.raises(RecordError, match=r"run.mcap: cannot be written: File too large"):
            made.file.flush()
        made.file.finish()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert [(each.topic, each.came, each.data) for each in raw_messages(made.path, list(TOPICS))] == made.rows[:3]


def test_what_is_no_whole_recording_is_named_and_no_file_is_written_over(tmp_path):
    path = tmp_path / RECORDING
    with pytest.raises(RunError, match="No such file"):
        list(messages(path, ["plan"]))
    for content in (b"", b"\x89MCAP0\r\n", b"t,x,y\n" * 20):
        path.write_bytes(content)
        with pytest.raises(RunError, match=r"run.mcap: expected a recording"):
            list(messages(path, ["plan"]))
    with pytest.raises(RecordError, match=r"run.mcap: cannot be written: File exists"):
        RecordingFile(path)
    assert path.read_bytes() == content
    path.unlink()
    made = written(path)
    made.file.flush()
    assert len(list(messages(path, ["controller/reference"]))) == 3
    made.file.finish()
    assert len(list(messages(path, ["controller/reference"]))) == 3
