"""No output of a batch lies where an input lies, and no two outputs share a path, on any disk."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from app.enhancement.batch import enhance_batch, items_in
from app.enhancement.enhance_files import Setting, enhance_into
from app.enhancement.kept_inputs import identities
from app.errors import UserError
from app.files.image_series import open_series
from enhance import EnhanceParams
from tests.app.conftest import Cli, tissue
from tests.app.enhancement.test_batch import write_avi


def put(*paths: Path) -> None:
    for number, path in enumerate(paths):
        path.parent.mkdir(parents=True, exist_ok=True)
        assert cv2.imwrite(str(path), tissue(number))


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(inputs: list[Path], output: Path, *, below: bool) -> None:
    root = output.absolute().parents[0]
    before = contents(root)
    with pytest.raises(UserError, match=r"OUTPUT|output"):
        items_in(inputs, output, below=below)
    assert contents(root) == before


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder with nothing of other tests beside it."""
    (tmp_path / "home").mkdir()
    return tmp_path / "home"


@pytest.mark.parametrize("below", [False, True])
def test_outputs_in_the_folder_of_an_input_are_refused(home: Path, below: bool) -> None:
    put(home / "p.png", home / "q.png", home / "x/1.png", home / "y/1.png")
    write_avi(home / "a.avi")
    write_avi(home / "b.avi")
    for names in (("p.png", "q.png"), ("x", "y"), ("x", "p.png"), ("y", "b.avi")):
        refused([home / name for name in names], home, below=below)
    (home / "other/x").mkdir(parents=True)
    put(home / "other/x/1.png")
    refused([home / "x", home / "other/x"], home / "other", below=below)


def test_what_has_another_name_may_lie_beside_the_inputs(home: Path) -> None:
    put(home / "p.jpg", home / "q.png")
    for name in ("a.avi", "b.avi"):
        write_avi(home / name)
    (home / "c.mp4").write_bytes((home / "a.avi").read_bytes())
    given = [home / name for name in ("a.avi", "b.avi", "p.jpg")]
    assert len(items_in(given, home, below=False)) == 3
    refused([*given, home / "q.png"], home, below=False)
    refused([*given, home / "c.mp4"], home, below=False)


def test_what_this_program_did_not_make_is_not_replaced_unasked(home: Path, vesselsplat: Cli) -> None:
    put(home / "p.jpg", home / "q.jpg", home / "p.png", home / "out/q.png")
    write_avi(home / "a.avi")
    (home / "a.mp4").write_bytes((home / "a.avi").read_bytes())
    before = contents(home)
    call = vesselsplat("enhance", home / "a.avi", home / "p.jpg", home / "q.jpg", home)
    assert (call.code, "2 of 3 could not be enhanced: a.avi (expected no file there" in call.error) == (
        2,
        True,
    )
    assert {path.name for path in contents(home).keys() - before.keys()} == {"q.png"}
    assert vesselsplat("enhance", home / "q.jpg", home / "out").code == 2
    assert all(path.read_bytes() == content for path, content in before.items())
    (home / "a.mp4").unlink()
    (home / "p.png").unlink()
    for _ in range(2):
        assert vesselsplat("enhance", home / "a.avi", home / "p.jpg", home / "q.jpg", home).code == 0
        (home / "p.png.json").write_text('{"annotations": []}')
    assert vesselsplat("enhance", home / "q.jpg", home / "out/q.png").code == 0, "it is named"


def test_a_name_that_is_taken_is_told_before_the_work(home: Path) -> None:
    put(*(home / f"in/{name}.jpg" for name in "abc"), home / "out/c.png")
    steps = enhance_into(home / "out", open_series(home / "in"), Setting("paper", EnhanceParams()))
    made = []
    with pytest.raises(UserError, match=r"expected no file there.*c\.png"):
        made.extend(steps)
    assert not any(made)
    assert contents(home / "out").keys() == {home / "out/c.png"}


def test_only_what_is_read_of_a_folder_is_kept(tmp_path: Path) -> None:
    put(tmp_path / "clip/1.png", tmp_path / "made/enh/1.png")
    (tmp_path / "made/notes.txt").write_text("seen")
    (tmp_path / "clip/results").symlink_to(tmp_path / "made/enh")
    (tmp_path / "clip/notes.txt").symlink_to(tmp_path / "made/notes.txt")
    assert len(items_in([tmp_path / "clip"], tmp_path / "made", below=True)) == 1


def test_where_a_disk_numbers_no_files_paths_tell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(tmp_path / "a.png", tmp_path / "b.png")
    (tmp_path / "c.png").symlink_to(tmp_path / "a.png")
    unnumbered = SimpleNamespace(st_dev=1, st_ino=0)
    monkeypatch.setattr(Path, "stat", lambda path: unnumbered)
    own, other, link = (identities([tmp_path / name]) for name in ("a.png", "b.png", "c.png"))
    monkeypatch.undo()
    assert own == link
    assert own.isdisjoint(other)


def test_the_command_says_so_and_keeps_the_inputs(tmp_path: Path, vesselsplat: Cli) -> None:
    put(tmp_path / "p.png", tmp_path / "q.png")
    before = contents(tmp_path)
    given = tmp_path / "p.png", tmp_path / "q.png"
    for output, said in ((tmp_path, "never overwritten"), (tmp_path / "out.dcm", "expected a folder")):
        call = vesselsplat("enhance", *given, output)
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert said in call.error
    assert contents(tmp_path) == before


def test_links_do_not_hide_an_input(tmp_path: Path) -> None:
    put(tmp_path / "in/sub/1.png", tmp_path / "out/2.png", tmp_path / "in/3.png")
    (tmp_path / "out/sub").symlink_to(tmp_path / "in/sub")
    refused([tmp_path / "in"], tmp_path / "out", below=True)
    (tmp_path / "out/sub").unlink()
    assert len(items_in([tmp_path / "in"], tmp_path / "out", below=True)) == 2
    (tmp_path / "in/2.png").symlink_to(tmp_path / "out/2.png")
    refused([tmp_path / "in"], tmp_path / "out", below=True)
    refused([tmp_path / "in/2.png", tmp_path / "in/3.png"], tmp_path / "out", below=False)
    (tmp_path / "same").symlink_to(tmp_path / "in")
    refused([tmp_path / "in"], tmp_path / "same/new", below=True)


def test_the_linked_folder_of_a_clip_is_not_written_into(tmp_path: Path) -> None:
    put(tmp_path / "pool/images/1.png", tmp_path / "pool/images/2.png")
    (tmp_path / "in").mkdir()
    (tmp_path / "in/images").symlink_to(tmp_path / "pool/images")
    refused([tmp_path / "in"], tmp_path / "pool/images", below=False)


def test_videos_and_folders_of_one_tree_do_not_share_an_output(tmp_path: Path) -> None:
    root = tmp_path / "in"
    put(root / "a.mp4/1.png", root / "b.png/1.png", root / "b.jpg", root / "Case/1.png", root / "case/1.png")
    for name in ("a.mov.avi", "A.avi", "a.mkv", "a.mov.mp4.avi"):
        write_avi(root / name)
    write_avi(root / "a.mov")
    out = tmp_path / "out"
    items = items_in([root], out, below=True)
    own = [str(item.output.relative_to(out)).casefold() for item in items]
    assert len(set(own)) == len(items) == 10
    steps = list(enhance_batch(items, Setting("paper", EnhanceParams(d_factor=0.5))))
    broken = [step.name for step in steps if step.failed]
    written = [step.written for step in steps if step.written]
    assert (len(broken), len(written)) == (0, 10)
    assert len(list(out.rglob("*.mp4")) + list(out.rglob("*.png"))) >= 10


def test_inputs_of_several_kinds_do_not_share_an_output(tmp_path: Path) -> None:
    put(tmp_path / "x.png/1.png", tmp_path / "p/x.png", tmp_path / "y.mp4/1.png")
    write_avi(tmp_path / "y.avi")
    inputs = [tmp_path / name for name in ("x.png", "p/x.png", "y.mp4", "y.avi")]
    steps = list(enhance_batch(items_in(inputs, tmp_path / "out", below=False), Setting("clahe", None)))
    assert not [step.failed for step in steps if step.failed]
    found = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.*")}
    assert {"x.png-images/1.png", "x.png", "y.mp4-images/1.png", "y.mp4", "y.mp4.json"} <= found


def test_images_that_a_disk_takes_for_one_keep_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(tmp_path / "in/A.png", tmp_path / "in/a.png")
    exists = Path.exists

    def in_any_case(path: Path) -> bool:
        return exists(path) or any(
            each.name.casefold() == path.name.casefold()
            for each in (path.parent.iterdir() if path.parent.is_dir() else ())
        )

    monkeypatch.setattr(Path, "exists", in_any_case)
    items = items_in([tmp_path / "in"], tmp_path / "out", below=True)
    (written,) = (step.written for step in enhance_batch(items, Setting("clahe", None)) if step.written)
    assert {one.output for one in written.pictures} == {"A.png", "a-2.png"}
    images = [cv2.imread(str(path)) for path in sorted((tmp_path / "out").iterdir())]
    assert not np.array_equal(images[0], images[1])
