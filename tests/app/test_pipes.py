"""Pipes in place of files: refused in one line and never waited for."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from renderer.phantom import PhantomParams, write_phantom
from tests.app.conftest import ROOT

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
    done = subprocess.run(
        [sys.executable, "-m", "app", *given],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
        timeout=SECONDS, check=False,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == [name]


EACH_FILE = """
    import os, shutil, signal, sys
    from pathlib import Path
    from renderer.clip import ClipError
    from renderer.sources import open_clip

    clip, scratch = Path(sys.argv[1]), Path(sys.argv[2])
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
        print(file.relative_to(clip), flush=True)
        try:
            opened = open_clip(copy)
            for index in range(len(opened)):
                opened.read_frame(index)
        except ClipError as error:
            assert str(copy) in str(error), error
        signal.alarm(0)
"""


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes in folders")
@pytest.mark.parametrize("layout", ["endonerf", "scared"])
def test_a_pipe_within_a_clip_is_refused_and_never_waited_for(tmp_path: Path, layout: str) -> None:
    params = PhantomParams(n_frames=3, width=64, height=48, seed=1)
    write_phantom(tmp_path / "clip", params, layout)  # type: ignore[arg-type]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(EACH_FILE), str(tmp_path / "clip"), str(tmp_path)],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, f"{done.stdout.splitlines()[-1:]} {done.stderr[-600:]}"
    assert len(done.stdout.splitlines()) > 3
