"""Many inputs enhanced by one setting: structure is kept, a file is whole or absent, failures are told."""

from __future__ import annotations

import errno
import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from app.enhancement.batch import enhance_batch, items_in
from app.enhancement.enhance_files import Setting, Stream, enhance_into
from app.errors import UserError
from app.exports.replay.again import replay
from app.files import image_series
from app.files.image_files import ArrayImage, read_image
from app.files.image_series import open_series
from app.files.provenance import read_provenance
from app.files.records import Source
from enhance import EnhanceParams, enhance
from enhance.vessel import VesselParams
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from tests.app.conftest import Cli, tissue

SETTING = Setting("paper", EnhanceParams(d_factor=0.5))


def write_avi(path: Path, frames: int = 4) -> None:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for index in range(frames):
        writer.write(cv2.resize(tissue(index), (64, 48)))
    writer.release()


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    """Two patients: a folder of pictures, a video, a clip in EndoNeRF layout; and what is none of these."""
    root = tmp_path / "cases"
    for index, name in enumerate(("a/stills/1.png", "a/stills/2.png", "b/clip/images/000001.png")):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(root / name), tissue(index))
    cv2.imwrite(str(root / "b/clip/images/000002.png"), tissue(5))
    for part in ("masks", "depth"):
        (root / "b/clip" / part).mkdir()
        for number in (1, 2):
            cv2.imwrite(str(root / f"b/clip/{part}/00000{number}.png"), np.zeros((40, 60), np.uint8))
    np.save(root / "b/clip/poses_bounds.npy", np.zeros((2, 17)))
    write_avi(root / "a/scope.avi")
    (root / "a/notes.txt").write_text("no picture")
    (root / ".hidden").mkdir()
    cv2.imwrite(str(root / ".hidden/1.png"), tissue(0))
    return root


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_structure_is_kept_and_every_file_comes_again(
    cases: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    out = tmp_path / "out"
    call = vesselsplat("enhance", cases, out, "--recursive", "--d-factor", "0.5", "--json")
    assert call.code == 0
    assert files(out) == {
        "a/stills/1.png", "a/stills/2.png", "a/scope.mp4", "a/scope.mp4.json",
        "b/clip/000001.png", "b/clip/000002.png",
    }  # fmt: skip
    expected = enhance(read_image(cases / "a/stills/2.png"), EnhanceParams(d_factor=0.5)).image
    np.testing.assert_array_equal(read_image(out / "a/stills/2.png"), expected)
    assert len(open_clip(out / "a/scope.mp4")) == 4
    found = json.loads(call.out)
    assert [(one["output"], len(one["pictures"])) for one in found["items"]] == [
        ("a/scope.mp4", 4), ("a/stills", 2), ("b/clip", 2),
    ]  # fmt: skip
    assert str(tmp_path) not in json.dumps(found)
    sources = {"a/stills/1.png": "a/stills", "b/clip/000002.png": "b/clip/images", "a/scope.mp4": "a"}
    for made, source in sources.items():
        path = out / made
        again = tmp_path / f"again{path.suffix}"
        assert replay(path, (cases / source,), again).difference.is_none


def test_several_inputs_have_their_own_names(cases: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    (cases / "c").mkdir()
    cv2.imwrite(str(cases / "c/1.png"), tissue(7))
    out, first = tmp_path / "out", cases / "a/stills"
    inputs = (first, cases / "a/scope.avi", cases / "b/clip", first / "1.png", cases / "c/1.png")
    assert vesselsplat("enhance", *inputs, out, "--method", "vessel").code == 0
    assert files(out) == {
        "stills/1.png", "stills/2.png", "scope.mp4", "scope.mp4.json", "clip/000001.png", "clip/000002.png",
        "1.png", "1-2.png",
    }  # fmt: skip
    assert read_provenance(out / "1-2.png")["params"]["strength"] == VesselParams().strength
    assert not np.array_equal(read_image(out / "1.png"), read_image(out / "1-2.png"))


def test_one_bad_item_is_told_at_the_end_and_the_others_are_there(
    cases: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    (cases / "a/stills/2.png").write_bytes((cases / "a/stills/2.png").read_bytes()[:300])
    (cases / "a/broken.mp4").write_bytes(b"no video")
    out = tmp_path / "out"
    call = vesselsplat("enhance", cases, out, "--recursive", "--json")
    assert call.code == 2
    last = call.error.splitlines()[-1]
    assert "1 of 4 could not be enhanced" in last
    assert "1 of the images could not be read: stills/2.png" in last.replace("cases/a/", "")
    assert "broken.mp4" in last
    assert files(out) == {
        "a/scope.mp4", "a/scope.mp4.json", "a/stills/1.png", "b/clip/000001.png", "b/clip/000002.png",
    }  # fmt: skip
    assert not list(out.rglob("*.partial"))
    found = json.loads(call.out)
    assert [("failure" in one) for one in found["items"]] == [True, False, False, False]
    (damaged,) = (image for one in found["items"] for image in one.get("failed", ()))
    assert damaged["name"] == "2.png"


def test_an_array_that_is_no_image_is_passed_over_and_told(tmp_path: Path, vesselsplat: Cli) -> None:
    folder, out = tmp_path / "arrays", tmp_path / "out"
    folder.mkdir()
    for number in range(4):
        np.save(folder / f"{number}.npy", (tissue(number) / 255).astype(np.float32))
    holed = np.load(folder / "1.npy")
    holed[3, 4] = np.nan
    np.save(folder / "1.npy", holed)
    np.save(folder / "2.npy", holed[..., :2])
    call = vesselsplat("enhance", folder, out, "--statistics", "clip")
    assert (call.code, files(out)) == (2, {"0.tiff", "3.tiff"})
    assert "2 of 4 images could not be enhanced: 1.npy (expected an image without NaN" in call.error
    assert "2.npy (expected an image of shape" in call.error
    np.save(folder / "0.npy", holed)
    np.save(folder / "3.npy", holed)
    call = vesselsplat("enhance", folder, tmp_path / "none")
    assert (call.code, call.error.count("\n"), (tmp_path / "none").exists()) == (2, 1, False)


def test_what_may_not_be_read_is_passed_over(
    cases: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of files and folders of somebody else."""
    denied = {cases / "a/stills/2.png", cases / "b"}

    def asked(path: Path) -> None:
        if path in denied:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))

    listed, of, read = Path.iterdir, Source.of, read_image
    monkeypatch.setattr(Path, "iterdir", lambda path: (asked(path), listed(path))[1])
    monkeypatch.setattr(Source, "of", lambda path: (asked(path), of(path))[1])
    monkeypatch.setattr(image_series, "read_image", lambda path: (asked(path), read(path))[1])
    steps = list(enhance_batch(items_in([cases], tmp_path / "out", below=True), SETTING))
    failed = [(step.failed.name, step.failed.reason) for step in steps if step.failed]
    passed = [(one.name, one.reason) for step in steps if step.written for one in step.written.failed]
    assert failed == [("cases/b", "Permission denied: b")]
    assert passed == [("2.png", "Permission denied: 2.png")]
    monkeypatch.undo()
    assert files(tmp_path / "out") == {"a/stills/1.png", "a/scope.mp4", "a/scope.mp4.json"}


def test_what_ends_early_leaves_whole_items_alone(cases: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    items = items_in((cases,), out, below=True)
    steps = enhance_batch(items, SETTING)
    for step in steps:
        if step.place == 1 and step.done == 1:
            break
    steps.close()
    assert files(out) == {"a/scope.mp4", "a/scope.mp4.json"}


def test_statistics_are_pooled_for_each_item(cases: Path, tmp_path: Path) -> None:
    setting = Setting("vessel", VesselParams(), "clip", "tissue")
    items = items_in((cases / "a",), tmp_path / "out", below=True)
    steps = list(enhance_batch(items, setting))
    assert [step.failed for step in steps if step.failed] == []
    written = [step.written for step in steps if step.written is not None]
    assert [len(one.pictures) for one in written] == [4, 2]
    assert {one.statistics and one.statistics.scope for each in written for one in each.pictures} == {"clip"}
    (video,) = (tmp_path / "out").glob("*.mp4")
    assert replay(video, (cases / "a",), tmp_path / "again.mp4").difference.is_none


def test_the_measured_frames_are_counted_and_named(tmp_path: Path) -> None:
    write_avi(tmp_path / "a.avi", 40)
    told: dict[str, Sequence[str]] = {}

    def watch(stage: str, names: Sequence[str], items: Stream) -> Stream:
        told[stage] = names
        return items

    setting = Setting("vessel", VesselParams(), "clip")
    list(enhance_batch(items_in((tmp_path / "a.avi",), tmp_path / "out", below=False), setting, watch))
    measured = told["measure"]
    assert (len(measured), measured[0], measured[-1]) == (16, "frame-000000", "frame-000039")
    assert len(told["enhance"]) == 40


def test_measuring_can_be_given_up_after_each_frame(tmp_path: Path) -> None:
    write_avi(tmp_path / "a.avi", 40)
    series, seen = open_series(tmp_path / "a.avi"), list[int]()

    def read(index: int) -> ArrayImage:
        seen.append(index)
        return series.read(index)

    watched, setting = replace(series, read=read), Setting("vessel", VesselParams(), "clip")
    steps = enhance_into(tmp_path / "out/a.mp4", watched, setting)
    for measured in range(3):
        assert (next(steps), len(seen)) == (0, measured)
    steps.close()
    assert not (tmp_path / "out").exists()


def test_a_clip_of_many_folders_is_one_item(tmp_path: Path, vesselsplat: Cli) -> None:
    params = PhantomParams(n_frames=3, width=64, height=48)
    write_phantom(tmp_path / "cases/keyframe", params, layout="scared")
    out = tmp_path / "out"
    assert vesselsplat("enhance", tmp_path / "cases", out, "--recursive").code == 0
    assert files(out) == {f"keyframe/frame_data00000{index}.png" for index in range(3)}
    made = out / "keyframe/frame_data000002.png"
    clip = open_clip(tmp_path / "cases/keyframe")
    np.testing.assert_array_equal(read_image(made), enhance(clip.read_image(2), EnhanceParams()).image)
    assert vesselsplat("replay", made, "--source", tmp_path / "cases").code == 0


def test_a_linked_folder_is_left_out_with_a_word(cases: Path, tmp_path: Path) -> None:
    for name in ("more", ".cache", "depth"):
        (cases / "a" / name).symlink_to(cases / "b/clip")
    first, *others = items_in((cases / "a",), tmp_path / "out", below=True)
    maps, links = first.notices
    assert maps == "left out, depth maps beside the images: depth/"
    assert links == "left out, links to folders: more"
    assert not any(item.notices or "more" in item.name for item in others)


def test_links_in_a_folder_of_nothing_else_are_told_too(cases: Path, tmp_path: Path) -> None:
    (cases / "c").mkdir()
    (cases / "c/more").symlink_to(cases / "b/clip")
    first, *_ = items_in((cases,), tmp_path / "out", below=True)
    assert "left out, links to folders: cases/c/more" in first.notices
    with pytest.raises(UserError, match="found none in c; left out, links to folders: c/more"):
        items_in((cases / "c",), tmp_path / "out", below=True)


def test_videos_of_one_name_do_not_share_a_file(cases: Path, tmp_path: Path) -> None:
    write_avi(cases / "a/scope.mkv.avi")
    (cases / "a/scope.mov").write_bytes(b"")
    outputs = [item.output.name for item in items_in((cases / "a",), tmp_path / "out", below=True)]
    assert sorted(outputs) == ["scope.avi.mp4", "scope.mkv.mp4", "scope.mov.mp4", "stills"]


def test_no_two_inputs_share_an_output(tmp_path: Path) -> None:
    image = np.full((16, 16, 3), 90, np.uint8)
    given = [tmp_path / place for place in ("1/a.png", "2/A.png", "3/a-2.png")]
    for path in (*given, *(tmp_path / f"{place}/0.png" for place in ("1/case", "2/case", "3/case-2"))):
        path.parent.mkdir(parents=True, exist_ok=True)
        assert cv2.imwrite(str(path), image)
    folders = [tmp_path / "1/case", tmp_path / "2/case", tmp_path / "3/case-2"]
    for inputs in (given, folders, [*reversed(given), *reversed(folders)]):
        items = items_in(inputs, tmp_path / "out", below=False)
        steps = list(enhance_batch(items, SETTING))
        assert sum(len(step.written.pictures) for step in steps if step.written) == len(inputs)
        assert len({str(path).lower() for path in (tmp_path / "out").rglob("*.png")}) == len(inputs)
        shutil.rmtree(tmp_path / "out")


@pytest.mark.parametrize("values", [np.uint8, np.float32])
def test_pictures_of_one_name_are_written_in_a_format_that_holds_them(tmp_path: Path, values: type) -> None:
    given = [tmp_path / place / "f.tiff" for place in ("a", "b", "c")]
    for number, path in enumerate(given):
        path.parent.mkdir()
        image = np.full((16, 16, 3), 90 + 20 * number, values)
        assert cv2.imwrite(str(path), image / np.float32(255) if values == np.float32 else image)
    steps = list(enhance_batch(items_in(given, tmp_path / "out", below=False), SETTING))
    assert not any(step.failed for step in steps)
    suffix = "tiff" if values == np.float32 else "png"
    assert files(tmp_path / "out") == {f"{name}.{suffix}" for name in ("f", "f-2", "f-3")}
    assert read_provenance(tmp_path / f"out/f-2.{suffix}")["source"]["name"] == "f.tiff"


def test_what_cannot_be_is_one_line(cases: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "empty").mkdir()
    wrong: list[tuple[tuple[object, ...], str]] = [
        ((cases, cases / "out", "--recursive"), "output outside"),
        ((cases / "a", cases / "none", tmp_path / "out"), "no such file"),
        ((tmp_path / "empty", tmp_path / "out", "--recursive"), "found none"),
        ((cases / "a/stills", cases / "b/clip", tmp_path / "out.png"), "expected a folder"),
        ((cases / "a/stills", cases / "b/clip", tmp_path / "out.avi"), "expected a folder"),
        ((cases / "a/stills", tmp_path / "out", "--stereo", "side-by-side"), "--stereo side-by-side has no"),
        (
            (cases / "b", tmp_path / "out", "--recursive", "--deinterlacing", "field"),
            "has no effect on images",
        ),
    ]
    for flags, said in wrong:
        call = vesselsplat("enhance", *flags)
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert said in call.error
    assert not (tmp_path / "out").exists()
    with pytest.raises(UserError, match="no such file"):
        items_in((tmp_path / "none",), tmp_path / "out", below=False)


def test_an_animation_is_a_video_of_its_folder(tmp_path: Path) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    first, *others = (Image.fromarray(tissue(index)) for index in range(4))
    first.save(folder / "scope.gif", save_all=True, append_images=others, duration=100)
    steps = list(enhance_batch(items_in([folder], tmp_path / "out", below=True), SETTING))
    assert [step.failed for step in steps if step.failed is not None] == []
    assert len(open_clip(tmp_path / "out/scope.mp4")) == 4


def test_a_folder_with_nothing_to_enhance_beside_others_is_named(cases: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    first, *_ = items_in((tmp_path / "empty", cases / "a/stills"), tmp_path / "out", below=True)
    assert first.notices == ("left out, nothing to enhance in empty",)


@pytest.mark.parametrize("given", [".", "below/.."])
def test_the_current_folder_has_its_name(
    given: str, cases: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "empty/below").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "empty")
    first, *_ = items_in((Path(given), cases / "a/stills"), tmp_path / "out", below=True)
    assert first.notices == ("left out, nothing to enhance in empty",)
    with pytest.raises(UserError, match=r"found none in empty$"):
        items_in((Path(given),), tmp_path / "out", below=True)
