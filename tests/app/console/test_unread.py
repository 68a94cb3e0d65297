"""Nobody reads stderr any more: the work goes on to its end, and its exit code stays."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
TALK = """
import sys
from app import __main__ as program
from app.console.progress import Terminal

def talk(arguments):
    for line in range(3):
        sys.stderr.write(f"told {line}\\n")
        Terminal(stderr=True).print("told")
    print("done")

program.run = talk
sys.exit(program.main([]))
"""
"""Work that says something before its end."""
STREAMS = [
    "pipe",
    pytest.param("/dev/full", marks=pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux's")),
]


def unheard(stream: str, *arguments: str) -> tuple[int, str]:
    """Exit code and stdout of Python whose stderr takes nothing."""
    if stream == "pipe":
        read, number = os.pipe()
        os.close(read)
    else:
        number = os.open(stream, os.O_WRONLY)
    try:
        done = subprocess.run(
            [sys.executable, *arguments], stdout=subprocess.PIPE, stderr=number, cwd=ROOT, text=True
        )
    finally:
        os.close(number)
    return done.returncode, done.stdout


@pytest.mark.parametrize("stream", STREAMS)
def test_the_work_goes_on(stream: str) -> None:
    assert unheard(stream, "-c", TALK) == (0, "done\n")


@pytest.mark.parametrize("stream", STREAMS)
def test_a_mistake_keeps_its_exit_code(stream: str) -> None:
    assert unheard(stream, "-m", "app", "info", "missing") == (2, "")
