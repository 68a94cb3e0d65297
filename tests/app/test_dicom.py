"""Commands on DICOM objects: read like stills and videos, written with what the standard asks for."""

from __future__ import annotations

import errno
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from pydicom import Dataset, dcmread
from pydicom.encaps import get_frame
from pydicom.tag import Tag, tag_in_exception

from app.__main__ import main
from app.enhancement import dicom_files
from app.errors import UserError
from app.exports.replay.recorded import recorded
from app.files.dicom.writing import quiet, require_level
from app.files.image_files import read_image
from app.gui.work.listing import thumbnail_of
from renderer.readers.dicom import opening
from renderer.readers.video_header import read_video_header
from renderer.sources import open_clip
from tests.app.conftest import Cli
from tests.renderer.readers.dicom_files import (
    VIDEO,
    labelled,
    picture,
    saved,
    stills,
    video,
    video_file,
    with_pixels,
)

IMAGE = picture()
FRAMES = [picture(seed=seed) for seed in range(6)]
SECRETS = ("Müller", "PID-4711", "19500102", "20240501", "ACC-A77", "Clinic", "2.25.11\0", "mueller")
"""Of the source, its name among them."""


def test_a_folder_of_stills_and_videos_is_enhanced(vesselsplat: Cli, tmp_path: Path) -> None:
    given, made = tmp_path / "given", tmp_path / "made"
    given.mkdir()
    kinds = stills(IMAGE)
    for name, kind in (("1.dcm", "rgb"), ("2.dcm", "rle")):
        saved(kinds[kind][0], given / name)
    saved(with_pixels(labelled(VIDEO), np.stack(FRAMES)), given / "film.dcm")
    assert vesselsplat("enhance", given, made, "--recursive").code == 0
    assert sorted(path.name for path in made.iterdir()) == ["1.png", "2.png", "film.mp4", "film.mp4.json"]
    assert np.array_equal(read_image(made / "1.png"), read_image(made / "2.png"))


def test_thumbnails_are_those_of_stills_frames_and_streams(tmp_path: Path) -> None:
    content = video_file(tmp_path / "a.ts", FRAMES, "mpegts")
    (tmp_path / "a.ts").rename(tmp_path / "a.mts")
    saved(video(content, (64, 48), len(FRAMES), "40"), tmp_path / "a.dcm")
    saved(with_pixels(labelled(VIDEO), np.stack(FRAMES)), tmp_path / "b.dcm")
    for path in (saved(stills(IMAGE)["grey 12"][0], tmp_path / "c.dcm"), *tmp_path.iterdir()):
        (image,) = thumbnail_of(path)
        assert image is not None
        assert image.shape == (48, 64, 3)


def test_more_than_8_bits_are_kept(vesselsplat: Cli, tmp_path: Path) -> None:
    grey = cv2.cvtColor(IMAGE, cv2.COLOR_RGB2GRAY)
    for kind, levels in (("grey 12", grey), ("rgb 16", IMAGE)):
        path = saved(stills(IMAGE)[kind][0], tmp_path / "a.dcm")
        assert np.abs(read_image(path).astype(int) - 257 * levels.astype(int)).max() < 257
        assert vesselsplat("enhance", path, tmp_path / "a.png").code == 0
        assert read_image(tmp_path / "a.png").dtype == np.uint16


def test_an_object_without_its_mark_is_told_how_to_get_one(vesselsplat: Cli, tmp_path: Path) -> None:
    path = saved(stills(IMAGE)["rgb"][0], tmp_path / "a.dcm")
    path.write_bytes(path.read_bytes()[132:])
    for command in (("enhance", path, tmp_path / "a.png"), ("info", path)):
        done = vesselsplat(*command)
        assert (done.code, "got a file without the mark of DICOM: dcmconv" in done.error) == (2, True)


def test_without_pydicom_a_line_says_what_to_install(
    vesselsplat: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = saved(stills(IMAGE)["rgb"][0], tmp_path / "a.dcm")
    monkeypatch.setattr(opening, "find_spec", lambda name: None)
    for command in (("enhance", path, tmp_path / "a.png"), ("info", path), ("train", path, "--run", "run")):
        done = vesselsplat(*command)
        assert (done.code, done.error.count("\n")) == (2, 1)
        assert "a DICOM file needs pydicom: pip install pydicom" in done.error


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Objects that commands write: a still and a video, of nobody and with their identity. Read only."""
    folder = tmp_path_factory.mktemp("dicom")
    saved(stills(IMAGE)["rgb"][0], folder / "mueller.dcm")
    content = video_file(folder / "plain.mp4", FRAMES, sound=True)
    saved(video(content, (64, 48), len(FRAMES), "40"), folder / "film.dcm")
    uneven = with_pixels(labelled(VIDEO), np.stack(FRAMES))
    uneven.FrameTimeVector = [0, 20, 60, 20, 60, 40]
    saved(uneven, folder / "uneven.dcm")
    Image.fromarray(IMAGE).save(folder / "bare.jpg")
    for source, output, *flags in (
        ("mueller.dcm", "still.dcm"),
        ("mueller.dcm", "still-kept.dcm", "--keep-identity", "--burned-in", "no"),
        ("mueller.dcm", "still.png"),
        ("bare.jpg", "bare.dcm"),
        ("film.dcm", "video.dcm"),
        ("film.dcm", "sound-kept.dcm", "--keep-identity"),
        ("film.dcm", "video.mp4"),
        ("uneven.dcm", "video-kept.dcm", "--keep-identity"),
    ):
        assert main(["enhance", str(folder / source), str(folder / output), *flags]) == 0
    return folder


WRITTEN = ("still.dcm", "still-kept.dcm", "bare.dcm", "video.dcm", "video-kept.dcm", "sound-kept.dcm")


def test_a_video_is_what_its_transfer_syntax_says_whatever_it_is_called(made: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.hevc.dcm"
    assert main(["enhance", str(made / "film.dcm"), str(path)]) == 0
    assert "H.264" in dcmread(path).file_meta.TransferSyntaxUID.name
    assert read_video_header(path).codec == "h264"


def test_an_object_says_that_it_is_derived_and_of_nobody(made: Path) -> None:
    for name, kind in (("still.dcm", VIDEO.removesuffix(".1")), ("video.dcm", VIDEO)):
        told = dcmread(made / name)
        assert (told.SOPClassUID, list(told.ImageType)) == (kind, ["DERIVED", "SECONDARY"])
        assert "method paper: Brightness auto" in told.DerivationDescription
        assert told.DerivationCodeSequence[0].CodeValue == "113086"
        assert told.SourceImageSequence[0].PurposeOfReferenceCodeSequence[0].CodeValue == "121322"
        assert (told.PatientIdentityRemoved, told.BurnedInAnnotation) == ("YES", "YES")
        assert told.DeidentificationMethod.startswith("DICOM PS3.15 Basic")
        assert told.DeidentificationMethodCodeSequence[0].CodeValue == "113100"
        content = (made / name).read_bytes()
        assert not [secret for secret in SECRETS if secret.encode() in content]
    still, video = dcmread(made / "still.dcm"), dcmread(made / "video.dcm")
    # Of one study and of one object: the same in place of the same.
    assert still.StudyInstanceUID != "2.25.22"
    assert still.SourceImageSequence[0].ReferencedSOPInstanceUID not in ("", "2.25.11")
    assert (still.LossyImageCompression, video.LossyImageCompression) == ("00", "01")
    assert dcmread(made / "bare.dcm").LossyImageCompression == "01"
    assert "notices" not in recorded(made / "video.dcm")
    assert read_video_header(made / "video.dcm").sound is None
    assert "SourceImageSequence" not in dcmread(made / "bare.dcm")


def test_identity_is_kept_where_it_is_asked_for(made: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    for name in ("still-kept.dcm", "video-kept.dcm"):
        told = dcmread(made / name)
        assert (str(told.PatientName), told.PatientID) == ("Müller^Hanna", "PID-4711")
        assert (told.StudyDate, told.AccessionNumber) == ("20240501", "ACC-A77")
        assert (told.StudyInstanceUID, told.SOPInstanceUID != "2.25.11") == ("2.25.22", True)
        assert told.SourceImageSequence[0].ReferencedSOPInstanceUID == "2.25.11"
        assert "PatientIdentityRemoved" not in told
    assert dcmread(made / "still-kept.dcm").BurnedInAnnotation == "NO"
    assert read_video_header(made / "sound-kept.dcm").sound == "aac"
    anonymous = labelled()
    del anonymous.PatientName, anonymous.PatientID
    nobody = saved(with_pixels(anonymous, IMAGE), tmp_path / "nobody.dcm")
    for source, output, line in (
        (made / "bare.jpg", "a.dcm", "--keep-identity expects one DICOM file as INPUT, got bare.jpg"),
        (nobody, "a.dcm", "--keep-identity expects a source with a patient, got none"),
        (made / "still.dcm", "a.png", "--keep-identity has no effect without a .dcm file"),
    ):
        done = vesselsplat("enhance", source, tmp_path / output, "--keep-identity")
        assert (done.code, line in done.error, (tmp_path / output).exists()) == (2, True, False)


def test_pixels_are_those_of_other_files_and_can_be_made_again(made: Path, vesselsplat: Cli) -> None:
    assert np.array_equal(read_image(made / "still.dcm"), read_image(made / "still.png"))
    film, plain = open_clip(made / "video.dcm"), open_clip(made / "video.mp4")
    assert (len(film), film.frames_per_second) == (len(plain), plain.frames_per_second) == (6, 25)
    assert all(np.array_equal(film.read_image(at), plain.read_image(at)) for at in range(6))
    assert open_clip(made / "video-kept.dcm").frame_times == pytest.approx((0, 0.02, 0.08, 0.1, 0.16, 0.2))
    assert [float(step) for step in dcmread(made / "video-kept.dcm").FrameTimeVector] == [
        0,
        20,
        60,
        20,
        60,
        40,
    ]
    for name, source in (("still.dcm", "mueller.dcm"), ("video.dcm", "film.dcm")):
        for place in (made / source, made):
            done = vesselsplat("replay", made / name, "--source", place, "--json")
            assert (done.code, '"identical": true' in done.out) == (0, True), done.error + done.out


def test_what_dicom_has_no_room_for_is_refused(made: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    Image.fromarray(np.zeros((64, 64), np.uint16)).save(tmp_path / "deep.png")
    done = vesselsplat("enhance", tmp_path / "deep.png", tmp_path / "a.dcm")
    assert (done.code, ".dcm holds 8 bits a value, not uint16" in done.error) == (2, True)
    with pytest.raises(UserError, match=r"for H\.264 in DICOM, got 3840x2160 at 25 \("):
        require_level((3840, 2160), 25, Path("a.dcm"))
    assert require_level((1920, 1080), 60, Path("a.dcm")).endswith(".104")


@pytest.mark.skipif(not shutil.which("dciodvfy"), reason="needs dicom3tools")
@pytest.mark.parametrize("name", WRITTEN)
def test_a_validator_finds_no_error(made: Path, name: str) -> None:
    done = subprocess.run(["dciodvfy", str(made / name)], capture_output=True, text=True, errors="replace")
    lines = (done.stdout + done.stderr).splitlines()
    assert any("Endoscopic" in line for line in lines)
    assert not [line for line in lines if line.startswith("Error")]


@pytest.mark.skipif(not shutil.which("dcm2pnm"), reason="needs dcmtk")
def test_another_reader_sees_the_same(made: Path, tmp_path: Path) -> None:
    for name in ("still.dcm", "mueller.dcm"):
        subprocess.run(["dcm2pnm", "+op", str(made / name), str(tmp_path / "a.ppm")], check=True)
        assert np.array_equal(read_image(tmp_path / "a.ppm"), read_image(made / name))
    # As archives like it; the encoder's usual compression is lossless.
    subprocess.run(["dcmcjpeg", str(made / "mueller.dcm"), str(tmp_path / "kept.dcm")], check=True)
    assert np.array_equal(read_image(tmp_path / "kept.dcm"), IMAGE)
    subprocess.run(["dcmdump", "+W", str(tmp_path), str(made / "video.dcm")], check=True, capture_output=True)
    told = dcmread(made / "video.dcm")
    assert (tmp_path / "video.dcm.1.raw").read_bytes() == get_frame(told.PixelData, 0, number_of_frames=1)


def test_a_full_disk_is_told_as_the_system_does() -> None:
    """Not as pydicom does, with a traceback in its words."""
    with pytest.raises(OSError, match=r"^.Errno 28. full$"), quiet(), tag_in_exception(Tag("PixelData")):
        raise OSError(errno.ENOSPC, "full")


def test_a_full_disk_is_told_of_the_object(
    made: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(place: Path, *_: object) -> Iterator[int]:
        raise OSError(errno.ENOSPC, "No space left on device", str(place))
        yield

    monkeypatch.setattr(dicom_files, "write_frames", full)
    done = vesselsplat("enhance", made / "film.dcm", tmp_path / "a.dcm")
    assert (done.code, done.error.count("\n"), "film.mp4" in done.error) == (2, 1, False)
    assert f"No space left on device: {tmp_path / 'a.dcm'}" in done.error
    assert not any(tmp_path.iterdir())


def test_a_full_disk_is_told_of_a_still(
    tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The system names no file, and pydicom tells its error in words of its own."""

    def full(*_: object, **__: object) -> None:
        with tag_in_exception(Tag("PixelData")):
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Dataset, "save_as", full)
    cv2.imwrite(str(tmp_path / "a.png"), IMAGE)
    done = vesselsplat("enhance", tmp_path / "a.png", tmp_path / "a.dcm", "--burned-in", "no")
    assert (done.code, done.error) == (2, f"vesselsplat: No space left on device: {tmp_path / 'a.dcm'}\n")
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
