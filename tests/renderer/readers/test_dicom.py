"""DICOM objects open as stills and clips, whatever their names; what cannot be read is one line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from pydicom.uid import (
    UID,
    DeflatedExplicitVRLittleEndian,
    JPEGBaseline8Bit,
    JPEGLosslessSV1,
    JPEGLSLossless,
)

from renderer.clip import ClipError
from renderer.readers.video_header import read_counted_header, read_video_header
from renderer.sources import open_clip
from tests.renderer.readers.dicom_files import (
    VIDEO,
    compressed,
    encoded,
    labelled,
    lossless,
    lossless_of,
    picture,
    saved,
    stills,
    video,
    video_file,
    with_pixels,
)

IMAGE = picture()
GREY = cv2.cvtColor(IMAGE, cv2.COLOR_RGB2GRAY)
STILLS = stills(IMAGE)
FRAMES = [picture(seed=seed) for seed in range(6)]


@pytest.mark.parametrize("kind", STILLS)
def test_stills_hold_the_picture(kind: str, tmp_path: Path) -> None:
    made, tolerance = STILLS[kind]
    path = saved(made, tmp_path / "IM000001")
    clip = open_clip(path)
    grey = made.SamplesPerPixel == 1
    expected = np.repeat(GREY[:, :, None], 3, axis=2) if grey else IMAGE
    assert (clip.format, len(clip), clip.size) == ("image", 1, (64, 48))
    assert np.abs(clip.read_image(0).astype(int) - expected).max() <= tolerance


def test_a_still_opens_under_any_name_and_in_a_folder_beside_a_video(tmp_path: Path) -> None:
    for name in ("a.png", "a.mp4", "1.dcm", "2.dcm"):
        path = saved(STILLS["rgb"][0], tmp_path / name)
        assert np.array_equal(open_clip(path).read_image(0), IMAGE)
    for name in ("a.png", "a.mp4"):
        (tmp_path / name).unlink()
    saved(with_pixels(labelled(VIDEO), np.stack(FRAMES)), tmp_path / "film.dcm")
    assert open_clip(tmp_path).labels == ("1.dcm", "2.dcm")


def test_a_folder_from_an_archive_has_names_of_its_own(tmp_path: Path) -> None:
    for name in ("1.2.840.9", "1.2.840.10", "IM000002"):
        saved(STILLS["rgb"][0], tmp_path / name)
    for name, kind in (("DICOMDIR", "1.2.840.10008.1.3.10"), ("report.dcm", "1.2.840.10008.5.1.4.1.1.88.11")):
        saved(labelled(kind), tmp_path / name)
    (tmp_path / "README").write_text("of the archive")
    clip = open_clip(tmp_path)
    assert clip.labels == ("IM000002", "1.2.840.9", "1.2.840.10")
    assert clip.notices == ("left out, not numbered images: DICOMDIR, README, report.dcm",)


def test_frames_one_by_one_are_a_clip_with_the_times_of_its_header(tmp_path: Path) -> None:
    made = with_pixels(labelled(VIDEO), np.stack(FRAMES))
    clip = open_clip(saved(made, tmp_path / "a.dcm"))
    assert (clip.format, len(clip), clip.frames_per_second, clip.frame_times) == ("video", 6, None, None)
    assert all(np.array_equal(clip.read_image(number), frame) for number, frame in enumerate(FRAMES))
    made.CineRate, made.RecommendedDisplayFrameRate = 30, 15
    assert open_clip(saved(made, tmp_path / "b.dcm")).frames_per_second == 30
    made.FrameTimeVector = [0, 20, 60, 20, 60, 40]
    timed = open_clip(saved(made, tmp_path / "c.dcm"))
    assert timed.frames_per_second == pytest.approx(25)
    assert timed.frame_times == pytest.approx((0, 0.02, 0.08, 0.1, 0.16, 0.2))
    jpegs = with_pixels(labelled(VIDEO, JPEGBaseline8Bit), np.stack(FRAMES), "YBR_FULL_422")
    jpegs.FrameTime = "40"
    path = saved(
        compressed(jpegs, [encoded(frame, "JPEG", quality=97) for frame in FRAMES]), tmp_path / "d.dcm"
    )
    assert read_video_header(path).frames_per_second == open_clip(path).frames_per_second == 25
    assert np.abs(open_clip(path).read_image(5).astype(int) - FRAMES[5]).mean() < 2


def test_frames_of_a_file_that_is_cut_off_are_those_that_are_whole(tmp_path: Path) -> None:
    path = saved(with_pixels(labelled(VIDEO), np.stack(FRAMES)), tmp_path / "a.dcm")
    path.write_bytes(path.read_bytes()[:-10])
    clip = open_clip(path)
    assert len(clip) == 5
    assert clip.notices == ("the file is cut off or damaged at its end: 5 of 6 frames are whole",)
    header = read_counted_header(path)
    assert (header.frames, header.is_cut, header.is_announced) == (5, True, False)


@pytest.mark.parametrize(("share", "count"), [(0.95, 5), (0.6, 3), (0.3, 1)])
def test_of_frames_in_several_fragments_the_whole_ones_are_counted(
    share: float, count: int, tmp_path: Path
) -> None:
    jpegs = with_pixels(labelled(VIDEO, JPEGBaseline8Bit), np.stack(FRAMES), "YBR_FULL_422")
    coded = [encoded(frame, "JPEG", quality=97) for frame in FRAMES]
    path = saved(compressed(jpegs, coded, fragments=3), tmp_path / "a.dcm")
    whole = open_clip(path)
    assert (len(whole), whole.notices) == (6, ())
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - round((1 - share) * sum(map(len, coded)))])
    clip = open_clip(path)
    assert len(clip) == count
    assert "cut off or damaged at its end" in clip.notices[0]
    assert np.abs(clip.read_image(count - 1).astype(int) - FRAMES[count - 1]).mean() < 2


@pytest.mark.parametrize("share", [0.4, 0.6])
def test_a_video_inside_that_is_cut_off_says_so(share: float, tmp_path: Path) -> None:
    frames = [picture(seed=seed) for seed in range(40)]
    path = saved(video(video_file(tmp_path / "a.ts", frames), (64, 48), 40, "40"), tmp_path / "a.dcm")
    assert open_clip(path).notices == ()
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    clip = open_clip(path)
    assert abs(len(clip) - 40 * share) < 5
    assert clip.notices[0] == f"the file is cut off or damaged at its end: {len(clip)} frames are whole"
    header = read_counted_header(path)
    assert (header.frames, header.is_cut) == (len(clip), True)


def test_a_video_inside_is_read_where_it_lies(tmp_path: Path) -> None:
    content = video_file(tmp_path / "a.mp4", FRAMES)
    path = saved(video(content, (64, 48), 6, "40", fragments=4), tmp_path / "a.dcm")
    clip, plain = open_clip(path), open_clip(tmp_path / "a.mp4")
    assert (len(clip), clip.frames_per_second, clip.frame_times) == (6, 25, plain.frame_times)
    for number in (5, 0, 3):
        assert np.array_equal(clip.read_image(number), plain.read_image(number))
    # A bare stream tells no times: the object does.
    bare = video(video_file(tmp_path / "a.h264", FRAMES, "h264"), (64, 48), 6, "20", fragments=3)
    timed = open_clip(saved(bare, tmp_path / "b.dcm"))
    assert (len(timed), timed.frames_per_second) == (6, 50)
    assert timed.frame_times is not None
    assert timed.frame_times[1] == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("syntax", "codec", "form"),
    [
        (JPEGLosslessSV1, "ljpeg", "bgr24"),
        (JPEGLSLossless, "jpegls", "rgb24"),
        (JPEGLSLossless, "jpegls", "gray16le"),
    ],
)
def test_lossless_compressions_are_exact(syntax: UID, codec: str, form: str, tmp_path: Path) -> None:
    deep = (GREY.astype(np.uint32) * 65535 // 255).astype(np.uint16)
    stored = deep if form == "gray16le" else IMAGE
    kind = "MONOCHROME2" if form == "gray16le" else "RGB"
    made = with_pixels(labelled(syntax=syntax), stored, kind, 8 * stored.dtype.itemsize)
    frame = lossless(stored[..., ::-1] if form == "bgr24" else stored, codec, form)
    path = saved(compressed(made, [frame]), tmp_path / "a.dcm")
    expected = np.repeat(GREY[:, :, None], 3, axis=2) if form == "gray16le" else IMAGE
    assert np.array_equal(open_clip(path).read_image(0), expected)
    wide = compressed(with_pixels(labelled(syntax=syntax), stored[:, :32], kind, made.BitsStored), [frame])
    with pytest.raises(ClipError, match="expected an intact DICOM file, got a damaged one"):
        open_clip(saved(wide, tmp_path / "b.dcm"))


@pytest.mark.parametrize("precision", [9, 12, 16])
def test_lossless_values_of_fewer_bits_are_as_stored(precision: int, tmp_path: Path) -> None:
    """Of 12 bits in the object, whatever the frame's own precision."""
    most = (1 << min(precision, 12)) - 1
    stored = (GREY.astype(np.uint32) * most // 255).astype(np.uint16)
    made = with_pixels(labelled(syntax=JPEGLosslessSV1), stored, "MONOCHROME2", min(precision, 12))
    path = saved(compressed(made, [lossless_of(stored, precision)]), tmp_path / "a.dcm")
    plain = with_pixels(labelled(), stored, "MONOCHROME2", min(precision, 12))
    expected = open_clip(saved(plain, tmp_path / "b.dcm")).read_image(0)
    assert np.array_equal(open_clip(path).read_image(0), expected)


def test_what_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    signed = with_pixels(labelled(), GREY, "MONOCHROME2")
    signed.PixelRepresentation = 1
    undecoded = with_pixels(labelled(syntax=JPEGLosslessSV1), IMAGE, "YBR_FULL")
    undecoded = compressed(undecoded, [encoded(IMAGE, "JPEG")])
    other = compressed(with_pixels(labelled(syntax=JPEGBaseline8Bit), IMAGE), [encoded(picture(640), "JPEG")])
    packed = with_pixels(labelled(syntax=DeflatedExplicitVRLittleEndian), IMAGE)
    for made, line in (
        (signed, "expected a DICOM image of 1 or 3 values of 8 or 16 bits a pixel, got 1 of signed 8 bits"),
        (undecoded, r"a DICOM image of JPEG Lossless.* needs a decoder \(.*pylibjpeg"),
        (other, "expected a frame of 64x48, got 640x48"),
        (packed, r"expected a DICOM file that is not deflated \(dcmconv"),
        (
            labelled("1.2.840.10008.5.1.4.1.1.88.11"),
            "with an image, got one of Basic Text SR Storage without",
        ),
        (
            compressed(with_pixels(labelled(VIDEO, JPEGBaseline8Bit), IMAGE), []),
            "expected an intact frame 1 of 1, got a damaged one",
        ),
        (video(b"nothing", (64, 48), 6, "40"), "got one whose video is damaged"),
    ):
        path = saved(made, tmp_path / "a.dcm")
        with pytest.raises(ClipError, match=line):
            open_clip(path)
