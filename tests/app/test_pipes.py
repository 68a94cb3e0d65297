"""Pipes in place of files: refused in one line and never waited for."""

from __future__ import annotations

import os
import shutil
import signal
import sys
from pathlib import Path

import pytest

from renderer.clip import ClipError
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from tests.app.apart import called, command

SECONDS = 20
PIPES = [
    ("info", "{}"),
    ("enhance", "{}", "out.png"),
    ("train", "{}", "--run", "run"),
    ("render", "{}", "--out", "out"),
    ("replay", "{}"),
    ("metrics", "{}"),
    ("evaluate", "{}"),
    ("tune", "{}", "--out", "out"),
]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes in folders")
@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        *((arguments, "pipe.png") for arguments in PIPES),
        *((PIPES[0], f"pipe.{suffix}") for suffix in ("mp4", "ply", "vesselsplat", "json", "npy")),
        *((PIPES[1], f"pipe.{suffix}") for suffix in ("mp4", "npy")),
        (PIPES[3], "pipe.ply"),
    ],
)
def test_a_pipe_is_refused_and_never_waited_for(
    tmp_path: Path, arguments: tuple[str, ...], name: str
) -> None:
    os.mkfifo(tmp_path / name)
    given = [argument.format(tmp_path / name) for argument in arguments]
    done = command(*given, folder=tmp_path, seconds=SECONDS)
    assert done.code == 2, done.error
    assert "Traceback" not in done.error
    assert done.error.count("\n") == 1
    assert "no such file" not in done.error
    assert [path.name for path in tmp_path.iterdir()] == [name]


def open_each(clip: Path, scratch: Path) -> int:
    """The clip with a pipe in the place of one of its files, for the first of each kind in each folder."""
    seen = set()
    for file in sorted(path for path in clip.rglob("*") if path.is_file()):
        if (file.parent, file.suffix) in seen:
            continue
        seen.add((file.parent, file.suffix))
        copy = scratch / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(clip, copy)
        (copy / file.relative_to(clip)).unlink()
        os.mkfifo(copy / file.relative_to(clip))
        signal.alarm(10)
        sys.stdout.write(f"{file.relative_to(clip)}\n")
        sys.stdout.flush()
        try:
            opened = open_clip(copy)
            for index in range(len(opened)):
                opened.read_frame(index)
        except ClipError as error:
            if str(copy) not in str(error):
                raise
        signal.alarm(0)
    return 0


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes in folders")
@pytest.mark.parametrize("layout", ["endonerf", "scared"])
def test_a_pipe_within_a_clip_is_refused_and_never_waited_for(tmp_path: Path, layout: str) -> None:
    params = PhantomParams(n_frames=3, width=64, height=48, seed=1)
    write_phantom(tmp_path / "clip", params, layout)  # type: ignore[arg-type]
    done = called(open_each, tmp_path / "clip", tmp_path, folder=tmp_path)
    assert done.code == 0, f"{done.out.splitlines()[-1:]} {done.error[-600:]}"
    assert len(done.out.splitlines()) > 3
