"""The reference firmware's own tests, in C, and its decoder and device under random bytes, both with sanitizers."""

import shutil
import subprocess

import pytest
from c_compiler import NEEDS_COMPILER

from omnipuck_sim.emulator.c_library import COMPILER, firmware_sources

pytestmark = [NEEDS_COMPILER, pytest.mark.skipif(shutil.which("make") is None, reason="no make")]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("firmware") / "firmware"
    shutil.copytree(firmware_sources(), folder, ignore=shutil.ignore_patterns("build"))
    return folder


def made(folder, *arguments: str) -> str:
    done = subprocess.run(["make", "-C", folder, f"CC={COMPILER}", *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


def test_its_own_tests_pass(built):
    assert " checks, 0 failures\n" in made(built, "test")


def test_it_compiles_without_a_warning_or_a_library(built):
    made(built, "all", "STRICT=-Werror")
    undefined = subprocess.run(["nm", "-u", built / "build" / "libomnipuck_firmware.a"], capture_output=True, text=True)
    defined = subprocess.run(["nm", built / "build" / "libomnipuck_firmware.a"], capture_output=True, text=True).stdout
    asked = {line.split()[-1] for line in undefined.stdout.splitlines() if line.strip().startswith("U ")}
    own = {line.split()[-1] for line in defined.splitlines() if " T " in line}
    # what a compiler may call by itself
    assert asked - own <= {"memcpy", "memset", "memmove", "memcmp", "__stack_chk_fail", "_GLOBAL_OFFSET_TABLE_"}


@pytest.mark.parametrize("n", [100_000, pytest.param(10_000_000, marks=pytest.mark.soak)])
def test_random_inputs_break_neither_decoder_nor_rules(built, n):
    assert f"{n} inputs of seed 1" in made(built, "fuzz", f"N={n}", "SEED=1")
