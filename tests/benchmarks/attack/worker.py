"""A process that reads damaged files one after the other, under limits of memory and time.

It says a line of JSON for each failure and for each file that it begins, so that the one that ended the
process is known.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import tempfile
import traceback
from pathlib import Path
from types import FrameType
from zlib import crc32

from app.__main__ import keep_quiet, mistake
from app.errors import UserError
from renderer.camera_files import CameraFileError
from renderer.splat_files import SplatFileError
from tests.benchmarks.attack.mutations import mutated
from tests.benchmarks.attack.readers import readers

Case = tuple[str, int]
"""A reader and the number that makes a damaged file of it."""
MEMORY = 4 << 30
"""Bytes beyond what the process has when it begins."""
SECONDS = 10


class TooSlow(BaseException):
    """Not caught by what catches exceptions."""


def work(seeds: Path, cases: list[Case], streams: tuple[Path, Path]) -> None:
    """In a process of its own. `streams`: files for stdout and stderr, decoders' words as well."""
    for number, path in enumerate(streams, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), number)
    keep_quiet()
    every = readers(seeds)
    signal.signal(signal.SIGALRM, _late)
    _limit_memory()
    with tempfile.TemporaryDirectory() as scratch:
        for name, number in cases:
            print(json.dumps({"begins": name}), flush=True)
            reader = every[name]
            folder = Path(scratch) / "all"
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(seeds, folder, copy_function=_link)
            target = folder / reader.damaged
            content = target.read_bytes()
            target.unlink()
            target.write_bytes(mutated(content, crc32(name.encode()) + number))
            signal.alarm(SECONDS)
            try:
                reader.read(folder)
            except (UserError, CameraFileError, SplatFileError, OSError) as error:
                _require_line(error, name, number)
            except ValueError as error:
                if mistake(error) is None:
                    _tell(name, number, error)
            except BaseException as error:
                _tell(name, number, error)
            finally:
                signal.alarm(0)


def _link(source: str, target: str) -> None:
    """The files that stay as they are need no copy; the damaged one is written anew."""
    os.link(source, target)


def _late(number: int, frame: FrameType | None) -> None:
    raise TooSlow(f"more than {SECONDS} s")


def _limit_memory() -> None:
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))


def _require_line(error: Exception, name: str, number: int) -> None:
    if not str(error).strip():
        _tell(name, number, error)


def _tell(name: str, number: int, error: BaseException) -> None:
    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(last.filename).name}:{last.lineno}"
    ours = [
        each for each in traceback.extract_tb(error.__traceback__) if "site-packages" not in each.filename
    ]
    place = f"{Path(ours[-1].filename).name}:{ours[-1].lineno}"
    told = {
        "reader": name,
        "number": number,
        "error": type(error).__name__,
        "said": str(error)[:200],
        "in": where,
        "from": place,
    }
    print(json.dumps(told), flush=True)
