"""How several processes share the tests (pytest-xdist)."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from xdist.scheduler import LoadScopeScheduling


class WindowsInOne(LoadScopeScheduling):
    """A file to a process, whose tests share what they prepare; all files that open windows to one process,
    which has had no context without a window before (see `conftest`)."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.split("::")[0]
        return "windows" if opens_windows(file) else file


@cache
def opens_windows(file: str) -> bool:
    """`file`: from the repository's root."""
    text = (Path(__file__).parents[1] / file).read_text(encoding="utf-8")
    return "pytest.mark.display" in text
