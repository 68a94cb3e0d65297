"""Every layout of a clip: it opens, and its digest follows the files that decide what is read, no others."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, get_args

import cv2
import numpy as np
import pytest
from PIL import Image

from app.errors import UserError
from app.files.provenance import digest
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from assets import phantom_path
from renderer.clip import ClipError
from renderer.layouts import layout_of
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions, DepthSource
from renderer.sources import open_clip
from tests.app.conftest import request_of
from tests.renderer.eyes import write_eyes
from tests.renderer.readers.numbered import opencv_video
from tests.renderer.readers.test_hamlyn import write_hamlyn
from tests.renderer.readers.test_stereomis import write_converted, write_sequence
from tests.renderer.readers.test_structure_from_motion import write_structure_from_motion
from tests.renderer.small_clip import small_frames

SMALL = PhantomParams(n_frames=3, width=64, height=48)
COUNT = 3
ANY = ClipOptions(depth="off")
"""With which any clip opens."""
OPTIONS = [
    *(ClipOptions(depth=depth, mask_polarity="tool", baseline=4.0) for depth in get_args(DepthSource)),
    *(
        ClipOptions(depth="measured", mask_polarity=marked, evaluation_masks=counted, frame_step=1)
        for marked in ("tool", "tissue")
        for counted in ("masks", "gt_masks")
    ),
]
UNUSED = (
    ".DS_Store", "Thumbs.db", "notes.txt", "run/run.json", "run/model.safetensors", "exports/notes.txt",
    ".hidden/1.png", "point_cloud.obj",
)  # fmt: skip


def save(path: Path, array: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() == ".npy":
        with path.open("wb") as file:
            np.save(file, array)
    else:
        Image.fromarray(array).save(path)


def write_depth_files(folder: Path, images: str, maps: str) -> None:
    """Right pictures and monocular maps for the pictures of a folder."""
    for number, image in enumerate(sorted((folder / images).iterdir())):
        shutil.copy(image, folder / f"{images}_right" / image.name)
        with Image.open(image) as picture:
            inverse = np.full((picture.height, picture.width), 0.02 + 0.001 * number, np.float32)
        found = "".join(each for each in image.stem if each.isdigit())
        values = inverse if maps == "depth_dam" else (inverse * 5000).astype(np.uint8)
        save(folder / maps / (f"{found}.npy" if maps == "depth_dam" else f"{found}.png"), values)


def endonerf(folder: Path) -> Path:
    return phantom(folder, "endonerf")


def phantom(folder: Path, layout: Literal["endonerf", "scared"]) -> Path:
    """What its readers take."""
    write_phantom(folder, SMALL, layout=layout)
    shutil.rmtree(folder / "vessel_masks")
    (folder / "point_cloud.obj").unlink(missing_ok=True)
    return folder


def endonerf_with_maps(maps: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (endonerf(folder) / "images_right").mkdir()
        write_depth_files(folder, "images", maps)
        return folder

    return write


def scared(folder: Path) -> Path:
    phantom(folder, "scared")
    (folder / "data/right_finalpass").mkdir()
    for image in (folder / "data/left_finalpass").iterdir():
        shutil.copy(image, folder / "data/right_finalpass")
    return folder


def scared_of_points(folder: Path) -> Path:
    shutil.rmtree(scared(folder) / "data/disparity")
    points = np.zeros((2 * SMALL.height, SMALL.width, 3), np.float32)
    for image in (folder / "data/left_finalpass").iterdir():
        points[..., 2] = 60
        (folder / "data/scene_points").mkdir(exist_ok=True)
        tiff = folder / f"data/scene_points/{image.stem}.tiff"
        assert cv2.imwrite(str(tiff), points)
    return folder


def hamlyn_of_depth(folder: Path) -> Path:
    (write_hamlyn(folder) / "gt_depth").rename(folder / "depth")
    return folder


def eyes(left: str, right: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        write_eyes(folder, left, right, count=2, width=192, height=144, seed=41, noise=0.5)
        return folder

    return write


def pictures(
    image: str = "{}.png", depth: str = "", mask: str = "", one_mask: str = ""
) -> Callable[[Path], Path]:
    """Numbered pictures, with depth and masks of these names."""

    def write(folder: Path) -> Path:
        for frame in small_frames(count=COUNT):
            save(folder / image.format(frame.index), frame.image)
            assert frame.depth is not None
            marked = np.where(frame.tissue_mask, 0, 255).astype(np.uint8)
            in_steps = np.rint(100 * frame.depth).astype(np.uint16)
            if depth:
                whole = frame.depth if depth.endswith(".npy") else in_steps
                save(folder / depth.format(frame.index), whole)
            if mask:
                save(folder / mask.format(frame.index), marked)
            if one_mask and frame.index == 0:
                save(folder / one_mask, marked)
        return folder

    return write


def only_images(folder: Path) -> Path:
    (pictures("images/{}.png")(folder) / "images_right").mkdir()
    write_depth_files(folder, "images", "monodepth")
    return folder


def one_picture(folder: Path) -> Path:
    return pictures()(folder) / "1.png"


def video(folder: Path) -> Path:
    folder.mkdir()
    return opencv_video(folder / "clip.avi", "MJPG", COUNT)


def pages(folder: Path) -> Path:
    folder.mkdir()
    both = [Image.fromarray(frame.image) for frame in small_frames(count=2)]
    both[0].save(folder / "pages.tiff", save_all=True, append_images=both[1:])
    return folder / "pages.tiff"


LAYOUTS: dict[str, tuple[str, Callable[[Path], Path]]] = {
    "endonerf": ("endonerf", endonerf),
    "endonerf, both eyes, monodepth": ("endonerf", endonerf_with_maps("monodepth")),
    "endonerf, both eyes, depth_dam": ("endonerf", endonerf_with_maps("depth_dam")),
    "converted StereoMIS": ("endonerf", write_converted),
    "scared": ("scared", scared),
    "scared, scene_points": ("scared", scared_of_points),
    "structure from motion": ("structure-from-motion", write_structure_from_motion),
    "stereomis": ("stereomis", write_sequence),
    "hamlyn": ("hamlyn", write_hamlyn),
    "hamlyn, depth": ("hamlyn", hamlyn_of_depth),
    "left/ right/": ("stereo", eyes("left/{:06d}.png", "right/{:06d}.png")),
    "left/left_ right/right_": ("stereo", eyes("left/left_{:06d}.png", "right/right_{:06d}.png")),
    "img_left/ img_right/": ("stereo", eyes("img_left/{:06d}.png", "img_right/{:06d}.png")),
    "l/ r/": ("stereo", eyes("l/{:06d}.png", "r/{:06d}.png")),
    "image_02/ image_03/": ("stereo", eyes("image_02/{:06d}.png", "image_03/{:06d}.png")),
    "side by side": ("stereo", eyes("{:06d}l.png", "{:06d}r.png")),
    "pictures": ("images", pictures()),
    "images in images/": ("images", only_images),
    "pictures, depth beside": ("images", pictures(depth="{}_depth.png")),
    "pictures, arrays beside": ("images", pictures(depth="{}_depth.npy", mask="{}_mask.png")),
    "pictures, one mask": ("images", pictures(one_mask="mask.png")),
    "pictures without numbers beside numbered masks": (
        "images", lambda folder: renamed(pictures(mask="{}_mask.png")(folder)),
    ),
    "input/ depth/ mask/": ("images", pictures("input/{}.png", "depth/{}.npy", "mask/{}.png")),
    "input/ depth/ of large letters": ("images", pictures("input/{}.png", "depth/{}.NPY", "mask/{}.PNG")),
    "left/ depth/ right/": ("stereo", lambda folder: with_maps_of_left(folder)),
    "one picture": ("image", one_picture),
    "video": ("video", video),
    "pages": ("image", pages),
}  # fmt: skip


def renamed(folder: Path) -> Path:
    for number, name in enumerate("abc"):
        (folder / f"{number}.png").rename(folder / f"{name}.png")
    return folder


def with_maps_of_left(folder: Path) -> Path:
    eyes("left/{:06d}.png", "right/{:06d}.png")(folder)
    for number in range(2):
        save(folder / f"left/{number:06d}_depth.npy", np.full((144, 192), 50, np.float32))
        save(folder / f"mask/{number:06d}.png", np.zeros((144, 192), np.uint8))
    return folder


@pytest.fixture(params=LAYOUTS, ids=lambda name: name.replace("/", ""))
def layout(request: pytest.FixtureRequest) -> tuple[str, Callable[[Path], Path]]:
    return LAYOUTS[request.param]


@pytest.fixture
def clip(layout: tuple[str, Callable[[Path], Path]], tmp_path: Path) -> Path:
    (tmp_path / "place").mkdir()
    return layout[1](tmp_path / "place" / "clip")


def files_of(clip: Path) -> list[Path]:
    return sorted(path for path in clip.rglob("*") if path.is_file()) if clip.is_dir() else [clip]


OPENED: list[set[Path]] = []


def _note(event: str, arguments: tuple[object, ...]) -> None:
    if OPENED and event == "open" and isinstance(arguments[0], str):
        OPENED[-1].add(Path(arguments[0]).resolve())


sys.addaudithook(_note)


@contextmanager
def opened_files() -> Iterator[set[Path]]:
    """What Python opens meanwhile."""
    OPENED.append(set())
    try:
        yield OPENED[-1]
    finally:
        OPENED.pop()


def test_it_opens_as_what_it_is_and_reads_only_files_that_it_tells(
    layout: tuple[str, Callable[[Path], Path]], clip: Path
) -> None:
    assert layout_of(clip).name == layout[0]
    told = {path.resolve() for path in layout_of(clip).files(clip)}
    with opened_files() as opened:
        frames = open_clip(clip)
        for index in range(len(frames)):
            frames.read_frame(index)
        for options in OPTIONS:
            try:
                frames = open_clip(clip, options)
                for index in range(len(frames)):
                    frames.read_frame(index)
            except ClipError:
                continue  # Another source of depth, or masks that mark the other.
    read = {path for path in opened if path.is_relative_to(clip.parent.resolve())}
    assert read <= told
    assert read or layout[0] == "video"  # FFmpeg opens those without a word to Python.


def test_its_digest_follows_every_file_that_decides(clip: Path) -> None:
    before, kinds = digest(clip), set[tuple[Path, str]]()
    for path in files_of(clip):
        content = path.read_bytes()
        path.write_bytes(content + b" ")
        assert digest(clip) != before, f"{path} changed"
        if clip.is_dir() and (path.parent, path.suffix) not in kinds:
            kinds.add((path.parent, path.suffix))
            path.unlink()
            assert digest(clip) != before, f"{path} gone"
        path.write_bytes(content)
    assert digest(clip) == before


def test_its_digest_passes_over_what_is_not_read(clip: Path) -> None:
    before = digest(clip)
    folder = clip if clip.is_dir() else clip.parent
    for name in UNUSED:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(b"not of the clip")
        assert digest(clip) == before, name
    assert len(open_clip(clip)) > 0


def test_a_copy_elsewhere_has_its_digest(clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path(shutil.copytree(clip.parent, tmp_path / "other" / "place"))
    copy = folder / clip.name
    assert digest(copy) == digest(clip)
    monkeypatch.chdir(folder)
    assert digest(Path(clip.name)) == digest(clip)


def began_with(run: Path, sha256: str) -> RunFolder:
    """The same run, now of a clip of this digest."""
    path = RunFolder(run).record_path
    facts = json.loads(path.read_text())
    facts["clip"] |= {"sha256": sha256, "options": {"depth": ANY.depth}}
    path.write_text(json.dumps(facts))
    return RunFolder(run)


def test_a_run_goes_on_with_an_equal_copy_and_no_other_clip(
    clip: Path, runs: dict[str, Path], tmp_path: Path
) -> None:
    run = began_with(Path(shutil.copytree(runs["original"], tmp_path / "run")), digest(clip))
    copy = Path(shutil.copytree(clip.parent, tmp_path / "other")) / clip.name
    assert len(list(run_training(request_of(copy, run.path, resume=True, clip_options=ANY)))) == 1
    for path in (files_of(copy)[0], files_of(copy)[-1]):
        content = path.read_bytes()
        path.write_bytes(content + b" ")
        with pytest.raises(UserError, match="expected the clip the run was started with"):
            list(run_training(request_of(copy, run.path, resume=True, clip_options=ANY)))
        path.write_bytes(content)


@pytest.mark.parametrize("name", ["left", "images"])
def test_a_folder_depends_on_that_of_the_right_eye_beside_it(tmp_path: Path, name: str) -> None:
    right = {"left": "right", "images": "images_right"}[name]
    clip = eyes(name + "/{:06d}.png", right + "/{:06d}.png")(tmp_path / "clip") / name
    assert open_clip(clip).depth_origin == "stereo"
    before = digest(clip)
    shutil.copytree(clip.parent, tmp_path / "copy")
    assert digest(tmp_path / "copy" / name) == before
    (clip.parent / right / "000001.png").write_bytes(b"another")
    assert digest(clip) != before
    shutil.rmtree(clip.parent / right)
    assert digest(clip) != before


def test_a_digest_stays_what_it_was() -> None:
    assert digest(phantom_path()) == "b2ef0ca5b34d5d72a1585cf1dadea47ab349f518d248510a3dd31659bb7b2064"
