"""SDF files that mean harm, or are no SDF at all."""

import gzip
import os
import tracemalloc

import pytest

from collplan_core.worlds import WorldError
from collplan_study.barn import xml_file
from collplan_study.barn.sdf import load_sdf
from sdf_files import CYLINDER, GOAL, START, model, write, write_text

LAUGHS = "<!ENTITY a0 'ha'>" + "".join(f"<!ENTITY a{n + 1} '{f'&a{n};' * 10}'>" for n in range(9))

ZIPPED = gzip.compress(b"<sdf></sdf>", mtime=0)


def refusal(path):
    with pytest.raises(WorldError) as caught:
        load_sdf(path, START, GOAL)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    "declaration",
    [
        f"<!DOCTYPE sdf [{LAUGHS}]>",
        "<!DOCTYPE sdf [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>",
        "<!DOCTYPE sdf [<!ENTITY % x SYSTEM 'http://127.0.0.1:9/x'> %x;]>",
        "<!DOCTYPE sdf SYSTEM 'http://127.0.0.1:9/sdf.dtd'>",
    ],
)
@pytest.mark.parametrize("compressed", [False, True])
def test_declarations_are_refused(tmp_path, declaration, compressed):
    body = f"<sdf><world name='&a9;&x;'>{model(CYLINDER)}</world></sdf>"
    path = write_text(tmp_path, f"<?xml version='1.0'?>\n{declaration}\n{body}", compressed=compressed)
    assert refusal(path).startswith(f"{path}:2: a document type or entity declaration")


def test_a_gzip_bomb_is_never_unpacked(tmp_path):
    bomb = tmp_path / "bomb.world.gz"
    with gzip.open(bomb, "wb", compresslevel=9) as file:
        file.write(b"<sdf>" + b" " * (4 * xml_file.LARGEST))
    tracemalloc.start()
    try:
        assert "larger than 16 MiB unpacked" in refusal(bomb)
        assert tracemalloc.get_traced_memory()[1] < 4 * xml_file.LARGEST
    finally:
        tracemalloc.stop()


def test_a_huge_file_is_never_read(tmp_path):
    path = tmp_path / "huge.world"
    with path.open("wb") as file:
        file.truncate(2**40)
    assert "larger than 16 MiB" in refusal(path)


def test_limits_of_elements_and_depth(tmp_path, monkeypatch):
    deep = write(tmp_path, "<model name='m'>" * 200, "</model>" * 200)
    assert "nested deeper than 100 elements" in refusal(deep)
    monkeypatch.setattr(xml_file, "MOST_ELEMENTS", 50)
    assert "more than 50 elements" in refusal(write(tmp_path, "\n<light/>" * 60))


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "not XML"),
        (b"\x1f\x8b", "cannot be read"),
        (ZIPPED[:-9], "cannot be read"),
        (ZIPPED[:12] + b"\xff" * 20, "cannot be read"),
        (gzip.compress(ZIPPED, mtime=0), "not XML"),
        (b"<sdf>\n<world>\n</sdf>", ":3: not XML (mismatched tag)"),
        (b"<sdf>\xff\xfe</sdf>", "not XML"),
        (b"<?xml version='1.0' encoding='nonsense'?><sdf/>", "not XML"),
        (b"<html/>", ":1: got <html>, expected <sdf>"),
        (b"bounds: [0, 0, 1, 1]\n", "not XML"),
        (b"<sdf/>", "got 0 worlds"),
    ],
)
def test_what_is_no_world(tmp_path, content, expected):
    path = tmp_path / "some.world"
    path.write_bytes(content)
    assert expected in refusal(path)


def test_what_is_no_file(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.world")
    assert "not a file" in refusal(tmp_path)
    os.mkfifo(tmp_path / "pipe.world")
    assert "not a file" in refusal(tmp_path / "pipe.world")
