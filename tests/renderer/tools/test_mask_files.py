"""Folders of tool masks: whose frame each is, and what a clip is without them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from renderer.camera import Camera
from renderer.clip import Clip, ClipError, Frame
from renderer.tools.mask_files import (
    digest_of,
    mask_names,
    masks_in,
    origin_of,
    with_tool_masks,
    write_mask,
)

SIZE = 32, 24


def clip(labels: tuple[str, ...]) -> Clip:
    camera, keep = Camera.from_fov(60, *SIZE), np.ones((24, 32), bool)
    image = np.full((24, 32, 3), 120, np.uint8)
    return Clip(
        name="flat", path=Path("flat"), format="images", cameras=(camera,) * len(labels), labels=labels,
        read_frame=lambda index: Frame(index, index / len(labels), image, camera, keep, keep),
        read_image=lambda index: image, has_depth=False, unit="mm",
    )  # fmt: skip


def left_half() -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    mask = np.zeros((24, 32), bool)
    mask[:, :16] = True
    return mask


def save(folder: Path, *names: str, size: tuple[int, int] = SIZE) -> None:
    folder.mkdir(exist_ok=True)
    for name in names:
        image = np.zeros((size[1], size[0]), np.uint8)
        image[:, : size[0] // 2] = 255
        Image.fromarray(image).save(folder / name)


@pytest.mark.parametrize(
    ("labels", "names", "found"),
    [
        (("a.jpg", "b.jpg", "c.jpg"), ("b.png",), {1}),
        (("0", "1", "12"), ("00012.png", "1.bmp"), {1, 2}),
        (("frame-1.png", "frame-2.png"), ("frame-1-mask.png", "frame-2-mask.png"), {0, 1}),
        (("f-0.color.png", "f-1.color.png", "f-2.color.png"), ("f-0.mask.png", "f-2.mask.png"), {0, 2}),
        (("a.png", "a.jpg"), ("a.jpg.png",), {1}),
        (("0", "1"), ("1.png", "notes.txt.png", "unrelated.png"), {1}),
    ],
)
def test_each_mask_finds_its_frame(
    labels: tuple[str, ...], names: tuple[str, ...], found: set[int], tmp_path: Path
) -> None:
    save(tmp_path, *names)
    assert set(masks_in(tmp_path, labels).files) == found


@pytest.mark.parametrize("pattern", ["{:03d}.png", "frame_{:03d}.png"])
def test_masks_counted_from_zero_belong_to_frames_counted_from_one(pattern: str, tmp_path: Path) -> None:
    labels = tuple(pattern.format(number) for number in range(1, 6))
    save(tmp_path, *(f"{number:03d}.png" for number in range(5)))
    masks = masks_in(tmp_path, labels)
    assert [masks.files[index].name for index in range(5)] == [f"{number:03d}.png" for number in range(5)]
    assert len(masks.notices) == 1
    assert masks.notices[0].endswith(f"in order, not by name: 000.png with {labels[0]}")
    save(tmp_path / "same", *labels)
    assert masks_in(tmp_path / "same", labels).notices == ()


def test_pairs_by_number_are_said_and_need_more_than_one(tmp_path: Path) -> None:
    labels = tuple(f"f{number}_x.png" for number in range(4))
    save(tmp_path, "case1_a.png")
    with pytest.raises(ClipError, match=r"such as f0_x\.png.* got 1 images of other names"):
        masks_in(tmp_path, labels)
    save(tmp_path, "case3_a.png")
    masks = masks_in(tmp_path, labels)
    assert set(masks.files) == {1, 3}
    (said,) = masks.notices
    assert said.endswith("are paired with the frames by number, not by name: case1_a.png with f1_x.png")


def test_masks_that_are_perhaps_shifted_are_refused(tmp_path: Path) -> None:
    save(tmp_path, *(f"frame_{number}.png" for number in range(4)))
    labels = tuple(f"frame_{number}.png" for number in range(1, 6))
    with pytest.raises(
        ClipError, match=r"frame_1\.png to frame_5\.png, got some .* none of them, frame_0\.png"
    ):
        masks_in(tmp_path, labels)


def test_masks_of_no_frame_are_named(tmp_path: Path) -> None:
    save(tmp_path, "1.png", "7.png", "cover.png")
    masks = masks_in(tmp_path, ("0", "1", "7"))
    assert set(masks.files) == {1, 2}
    assert masks.notices == (f"masks in {tmp_path.name}/ that belong to no frame: cover.png",)


def test_what_is_written_is_found_again_bit_for_bit(tmp_path: Path) -> None:
    labels, random = ("x.tif", "x.png", "y.png"), np.random.default_rng(0)
    masks = [random.random((24, 32)) > 0.5 for _ in labels]
    for name, mask in zip(mask_names(labels), masks, strict=True):
        write_mask(tmp_path / name, mask, "learned")
    files = masks_in(tmp_path, labels)
    for index, mask in enumerate(masks):
        read = files.read(index, SIZE)
        assert read is not None
        np.testing.assert_array_equal(read, mask)
        assert origin_of(files.files[index]) == "learned"


def test_masks_of_others_count_as_drawn_by_hand(tmp_path: Path) -> None:
    save(tmp_path, "0.png")
    assert origin_of(tmp_path / "0.png") == "by hand"
    (tmp_path / "1.png").write_bytes(b"no image")
    assert origin_of(tmp_path / "1.png") == "by hand"


@pytest.mark.parametrize("name", ["0.png", "0.jpg"])
def test_a_mask_of_another_size_is_resampled_and_lossy_ones_have_no_fringe(name: str, tmp_path: Path) -> None:
    save(tmp_path, name, size=(64, 48))
    read = masks_in(tmp_path, ("0",)).read(0, SIZE)
    assert read is not None
    np.testing.assert_array_equal(read, left_half())


def test_masked_pixels_are_no_tissue_and_other_frames_are_as_they_were(tmp_path: Path) -> None:
    save(tmp_path, "1.png")
    source = clip(("0", "1"))
    masked = with_tool_masks(source, lambda: masks_in(tmp_path, source.labels))
    frame = masked.read_frame(1)
    np.testing.assert_array_equal(frame.tissue_mask, ~left_half())
    np.testing.assert_array_equal(frame.evaluation_mask, ~left_half())
    assert frame.tools_are_known
    assert not masked.read_frame(0).tools_are_known
    assert masked.read_frame(0).tissue_mask.all()
    np.testing.assert_array_equal(masked.read_frame(-1).tissue_mask, ~left_half())


def test_what_does_not_fit_is_named(tmp_path: Path) -> None:
    with pytest.raises(ClipError, match="no such folder"):
        masks_in(tmp_path / "nothing", ("0",))
    save(tmp_path / "others", "p.png", "q.png")
    with pytest.raises(ClipError, match=r"such as 0\.png.*got 2 images of other names"):
        masks_in(tmp_path / "others", ("0", "1", "2"))
    save(tmp_path / "wide", "0.png", size=(64, 24))
    with pytest.raises(ClipError, match="a mask of the shape of the images, 32x24"):
        masks_in(tmp_path / "wide", ("0",)).read(0, SIZE)
    save(tmp_path / "twice", "0.png", "00.bmp", "cover.png", "cover.bmp")
    with pytest.raises(
        ClipError, match=r"one mask for each frame, got (0\.png and 00\.bmp|00\.bmp and 0\.png)"
    ):
        masks_in(tmp_path / "twice", ("0",))
    seen = np.zeros((24, 32, 4), np.uint8)
    seen[:, :8, 3] = 255
    (tmp_path / "seen").mkdir()
    Image.fromarray(seen).save(tmp_path / "seen" / "0.png")
    with pytest.raises(ClipError, match="in the alpha alone"):
        masks_in(tmp_path / "seen", ("0",)).read(0, SIZE)


def test_the_digest_is_of_pixels_and_frames(tmp_path: Path) -> None:
    save(tmp_path, "0.png", "1.png")
    one, other = left_half(), ~left_half()
    masks = [(0, one), (1, other)]
    read = [(index, masks_in(tmp_path, ("0", "1")).read(index, SIZE)) for index in (0, 1)]
    assert digest_of(read) == digest_of([(0, one), (1, one)])  # type: ignore[arg-type]
    others = ([(0, one)], [(0, other), (1, one)], [(0, one), (2, other)], [(0, one.T), (1, other)])
    assert len({digest_of(each) for each in (masks, *others)}) == 5
