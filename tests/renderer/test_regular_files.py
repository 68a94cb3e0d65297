"""Whatever is read is a regular file, and named where it fails."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from renderer.regular_files import read_regular, read_whole


@pytest.mark.skipif(sys.platform != "linux", reason="a file of Linux that cannot be read from its start")
@pytest.mark.parametrize("read", [read_whole, read_regular])
def test_a_file_that_fails_while_it_is_read_is_named(read: Callable[[Path], bytes]) -> None:
    with pytest.raises(OSError, match="/proc/self/mem") as caught:
        read(Path("/proc/self/mem"))
    assert caught.value.filename == "/proc/self/mem"
    assert caught.value.strerror
