"""What a killed window has left is gone once the next one is open, before anything is written."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels, Server
from app.gui.update.update import update
from app.gui.work.settings import Places
from app.runs import shared_model
from app.runs.run_lock import LOCK, NAME, locked
from app.runs.shared_model import PREFIX
from renderer.leftovers import COMMIT, temporary_name
from tests.app.files.test_leftovers import gone, name_of

ELSEWHERE = re.sub(r"-\w+\.partial$", "-0badcafe.partial", temporary_name("checkpoint-00000010.safetensors"))
FORMERLY = (
    "checkpoint-00000010.safetensors.partial",
    ".model-41-0badcafe.partial.safetensors",
    "..model-7-41.977-0badcafe.partial.safetensors-7-41.977-0badcafe.partial",
)
"""Of trainings that another machine had begun, the latter of versions to 0.3.0 and of 0.4.0."""


@pytest.fixture
def dead() -> int:
    return gone()


@pytest.fixture(autouse=True)
def shared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where blocks of shared memory lie."""
    folder = tmp_path / "shared"
    folder.mkdir()
    monkeypatch.setattr(shared_model, "SHARED", folder)
    return folder


def start(places: Places) -> None:
    """The window without its drawing, for a frame."""
    channels = Channels()
    update(AppState(places), channels, 0.0)
    serve(channels, "second")
    serve(channels, "apart")


def serve(channels: Channels, server: Server) -> None:
    for channel in channels.of(server):
        channel.run_waiting()


def left(places: Places) -> list[str]:
    found = [path.name for folder in vars(places).values() for path in folder.rglob("*")]
    return sorted(name for name in found if name.startswith(".") or "partial" in name)


def test_what_was_being_written_is_gone_and_what_was_whole_is_put_into_place(
    places: Places, dead: int
) -> None:
    batch = places.pictures / "enhanced-1" / "below"
    run = places.runs / "first"
    for folder in (places.config, places.runs, batch, run):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name_of(dead, "a")).mkdir()
        (folder / name_of(dead, "a") / "half").write_text("x")
        (folder / name_of(dead, "b")).write_text("x")
    ready = places.pictures / name_of(dead, "c").replace(".partial", COMMIT)
    ready.mkdir()
    (ready / "a.mp4.json").write_text("new")
    start(places)
    assert left(places) == []
    assert (places.pictures / "a.mp4.json").read_text() == "new"


def test_runs_are_cleared_where_the_images_cannot_be_looked_at(
    places: Places, dead: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    look = Path.iterdir

    def refused(folder: Path) -> Iterator[Path]:
        if folder == places.pictures:
            raise PermissionError(folder)
        return look(folder)

    monkeypatch.setattr(Path, "iterdir", refused)
    for folder in (places.pictures, places.runs / "first"):
        folder.mkdir(parents=True)
    (places.runs / "first" / name_of(dead, "a")).write_text("x")
    start(places)
    assert left(places) == []


def test_batches_are_cleared_where_they_write_and_no_folder_of_others_is_searched(
    places: Places, tmp_path: Path, dead: int
) -> None:
    state, channels, chosen = AppState(places), Channels(), tmp_path / "results"
    names = ("enhanced-1/below", "enhanced-2", "mine/below")
    for folder in (root / name for root in (chosen, places.pictures) for name in names):
        folder.mkdir(parents=True)
        (folder / name_of(dead, "a")).write_text("x")
    state.window.folders = {"results": chosen}
    update(state, channels, 0.0)
    serve(channels, "second")
    # The drive that they lie on may not answer, which holds up nothing else.
    assert len(list(chosen.rglob(name_of(dead, "a")))) == len(names)
    serve(channels, "apart")
    found = {path.relative_to(tmp_path).parts[-3:-1] for path in tmp_path.rglob(name_of(dead, "a"))}
    assert found == {("mine", "below")}


def test_a_run_whose_training_was_killed_is_nobodys(places: Places) -> None:
    run = places.runs / "first"
    run.mkdir(parents=True)
    for name in (NAME, LOCK, ELSEWHERE, *FORMERLY):
        (run / name).write_text("")
    (run / "run.json").write_text("{}")
    start(places)
    assert [path.name for path in run.iterdir()] == ["run.json"]


def test_a_training_that_was_killed_as_it_began_leaves_nothing(places: Places) -> None:
    run = places.runs / "first"
    run.mkdir(parents=True)
    for name in (NAME, LOCK):
        (run / name).write_text("")
    start(places)
    assert left(places) == []


def test_what_goes_on_is_left_alone(places: Places, shared: Path) -> None:
    run = places.runs / "first"
    run.mkdir(parents=True)
    places.pictures.mkdir(exist_ok=True)
    mine = places.pictures / temporary_name("a")
    mine.write_text("x")
    (shared / f"{PREFIX}{os.getpid()}-abcd-1").write_text("x")
    with locked(run):
        (run / "model.safetensors.partial").write_text("x")
        start(places)
        assert sorted(path.name for path in run.iterdir()) == sorted(
            [NAME, LOCK, "model.safetensors.partial"]
        )
    assert mine.exists()
    assert len(list(shared.iterdir())) == 1


def test_partial_files_of_others_stay(places: Places) -> None:
    run, papers = places.runs / "first", places.runs / "papers"
    files = [
        run / "run.json",
        run / "big-download.zip.partial",
        run / "seen.ply.partial",
        papers / "model.safetensors.partial",
    ]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("{}")
    start(places)
    assert sorted(path for path in places.runs.rglob("*") if path.is_file()) == sorted(files)
    with locked(run):
        assert all(file.exists() for file in files)


def test_shared_memory_of_dead_windows_is_given_back(places: Places, dead: int, shared: Path) -> None:
    (shared / f"{PREFIX}{dead}-abcd-1").write_text("x")
    start(places)
    assert list(shared.iterdir()) == []
