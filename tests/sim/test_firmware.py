"""The line that an emulated firmware pretends to have, and the faults that it is asked for."""

import pytest

from collplan_core.parameters import EmulatorFaults
from collplan_core.parameters.spec import ParameterError
from omnipuck_sim.emulator.faults import BadLine


def test_a_good_line_changes_nothing_and_a_bad_one_does_what_it_was_asked():
    data = b"\0abcdefgh\0\0ijklmnop\0"
    assert BadLine(0).passed(data, EmulatorFaults()) == data
    assert BadLine(0).passed(data, EmulatorFaults(lost=1.0)) == b"\0\0\0\0"
    assert BadLine(0).passed(data, EmulatorFaults(doubled=1.0)) == b"\0abcdefgh\0abcdefgh\0\0ijklmnop\0ijklmnop\0"
    assert len(BadLine(0).passed(data, EmulatorFaults(cut=1.0))) < len(data)
    line = BadLine(0)
    assert line.passed(data, EmulatorFaults(split=1.0)) + line.passed(b"", EmulatorFaults()) == data
    noisy = BadLine(0).passed(data, EmulatorFaults(noise=1.0)).split(b"\0")
    assert noisy[2:3] == [b"abcdefgh"] or b"abcdefgh" in noisy
    flipped = BadLine(0).passed(bytes(8000), EmulatorFaults(flipped=0.25))
    assert sum(bin(byte).count("1") for byte in flipped) == pytest.approx(2000, rel=0.1)


def test_a_text_of_faults_is_read_or_refused_by_name():
    expected = EmulatorFaults(lost=0.1, unplugged=True, restarts=3)
    assert EmulatorFaults.read("lost=0.1, unplugged ,restarts=3") == expected
    for wrong in ("lost=2", "lots=1", "unplugged=3", "lost=[1", "lost"):
        with pytest.raises(ParameterError, match=r"emulator\.faults.*expected"):
            EmulatorFaults.read(wrong)
