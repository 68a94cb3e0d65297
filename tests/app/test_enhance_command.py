"""`vesselsplat enhance`: types kept, provenance embedded, statistics as asked."""

from __future__ import annotations

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.files.image_files import read_image
from app.files.image_series import open_series
from app.files.provenance import NOTICE, digest, read_provenance
from enhance import EnhanceParams, enhance, measure
from enhance.baselines import BASELINES
from enhance.surround import inside
from enhance.vessel import VesselParams, enhance_vessels
from renderer.sources import open_clip
from tests.app.conftest import Cli, tissue


def test_a_picture_is_what_the_library_makes_of_it(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = folder / "1.png", tmp_path / "new" / "out.png"
    call = vesselsplat("enhance", given, out, "--z", "0.3", "--p", "0.4", "--radii", "2", "5", "--json")
    assert call.code == 0
    params = EnhanceParams(z=0.3, p=0.4, radii=(2, 5))
    assert np.array_equal(read_image(out), enhance(read_image(given), params).image)
    facts = read_provenance(out)
    assert facts["source"] == {"name": "1.png", "sha256": digest(given)}
    assert (facts["params"]["z"], facts["params"]["radii"]) == (0.3, [2, 5])
    assert str(tmp_path) not in json.dumps(facts)
    summary = json.loads(call.out)
    assert summary["pictures"][0]["statistics"] == facts["statistics"]


@pytest.mark.parametrize("suffix", [".jpg", ".tiff"])
def test_jpeg_and_tiff_carry_their_provenance(
    folder: Path, tmp_path: Path, vesselsplat: Cli, suffix: str
) -> None:
    out = tmp_path / "out" / f"1{suffix}"
    assert vesselsplat("enhance", folder / "1.png", out, "--z", "0.3").code == 0
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    facts = read_provenance(out)
    assert facts["source"] == {"name": "1.png", "sha256": digest(folder / "1.png")}
    assert (facts["params"]["z"], facts["notice"]) == (0.3, NOTICE)


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("flags", [(), ("--pixels", "tissue", "--statistics", "clip"), ("--recursive",)])
def test_a_damaged_image_of_a_folder_is_passed_over_and_reported(
    folder: Path, tmp_path: Path, vesselsplat: Cli, number: int, flags: tuple[str, ...]
) -> None:
    damaged = folder / f"{number}.png"
    damaged.write_bytes(damaged.read_bytes()[:400])
    call = vesselsplat("enhance", folder, tmp_path / "out", *flags)
    assert call.code == 2
    (line,) = (line for line in call.error.splitlines() if damaged.name in line)
    assert line.startswith("vesselsplat: 1 of ")
    assert "damaged" in line
    others = {f"{other}.png" for other in range(3) if other != number}
    assert {path.name for path in (tmp_path / "out").iterdir()} == others
    for name in others:
        source = read_provenance(tmp_path / "out" / name)["source"]
        assert source == {"name": name, "sha256": digest(folder / name)}


def test_a_folder_of_damaged_images_alone_is_one_line(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    for path in folder.iterdir():
        path.write_bytes(path.read_bytes()[:400])
    call = vesselsplat("enhance", folder, tmp_path / "out")
    assert (call.code, len(call.error.splitlines())) == (2, 1)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("suffix", [".webp", ".npy"])
def test_what_carries_no_provenance_has_it_beside_it(
    folder: Path, tmp_path: Path, vesselsplat: Cli, suffix: str
) -> None:
    out = tmp_path / f"out{suffix}"
    assert vesselsplat("enhance", folder / "1.png", out, "--z", "0.3").code == 0
    facts = json.loads((tmp_path / f"out{suffix}.json").read_text())
    assert facts["source"] == {"name": "1.png", "sha256": digest(folder / "1.png")}
    assert (facts["params"]["z"], facts["notice"]) == (0.3, NOTICE)


def test_floats_of_a_folder_carry_their_provenance(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "in").mkdir()
    np.save(tmp_path / "in" / "1.npy", tissue(1) / np.float32(255))
    assert vesselsplat("enhance", tmp_path / "in", tmp_path / "out").code == 0
    (path,) = (tmp_path / "out").iterdir()
    assert read_provenance(path)["source"]["name"] == "1.npy"
    assert read_image(path).dtype == np.float32


@pytest.mark.parametrize("name", ["out.v1", "2024.05.01"])
def test_a_new_folder_may_have_a_dot_in_its_name(
    folder: Path, tmp_path: Path, vesselsplat: Cli, name: str
) -> None:
    assert vesselsplat("enhance", folder / "1.png", tmp_path / name).code == 0
    assert [path.name for path in (tmp_path / name).iterdir()] == ["1.png"]


def test_an_unknown_format_is_no_new_folder(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    refused = vesselsplat("enhance", folder / "1.png", tmp_path / "out.xyz")
    assert (refused.code, refused.error.count("\n")) == (2, 1)
    assert (
        "expected an image such as .png, .jpg or .tiff, a folder, .mp4, .webm or .dcm to write, got"
        in refused.error
    )
    assert not (tmp_path / "out.xyz").exists()
    (tmp_path / "out.xyz").mkdir()
    assert vesselsplat("enhance", folder / "1.png", tmp_path / "out.xyz").code == 0


def test_sixteen_bits_and_alpha_are_kept(tmp_path: Path, vesselsplat: Cli) -> None:
    colors = tissue(1).astype(np.uint16) * 257
    alpha = np.random.default_rng(0).integers(1, 65535, colors.shape[:2], dtype=np.uint16)
    cv2.imwrite(str(tmp_path / "in.png"), np.dstack((colors, alpha)))
    assert vesselsplat("enhance", tmp_path / "in.png", tmp_path / "out.png").code == 0
    out = cv2.imread(str(tmp_path / "out.png"), cv2.IMREAD_UNCHANGED)
    assert (out.dtype, out.shape) == (np.uint16, (40, 60, 4))
    assert np.array_equal(out[..., 3], alpha)
    assert not np.array_equal(out[..., :3], colors)


@pytest.mark.parametrize("statistics", ["image", "clip"])
def test_statistics_are_of_each_picture_or_of_all(
    folder: Path, tmp_path: Path, vesselsplat: Cli, statistics: str
) -> None:
    call = vesselsplat("enhance", folder, tmp_path / "out", "--statistics", statistics, "--json")
    images = [read_image(folder / f"{index}.png") for index in range(3)]
    pooled = measure(images, EnhanceParams()) if statistics == "clip" else None
    pictures = json.loads(call.out)["pictures"]
    assert [picture["output"] for picture in pictures] == ["0.png", "1.png", "2.png"]
    for image, picture in zip(images, pictures, strict=True):
        expected = enhance(image, EnhanceParams(), statistics=pooled)
        assert np.array_equal(read_image(tmp_path / "out" / picture["output"]), expected.image)
        assert picture["statistics"]["scope"] == statistics
    levels = {picture["statistics"]["level"] for picture in pictures}
    assert len(levels) == (1 if statistics == "clip" else 3)


@pytest.fixture
def scope(tmp_path: Path) -> Path:
    """A folder of three round pictures, the second of them brighter, in a black surround."""
    path = tmp_path / "round"
    path.mkdir()
    y, x = np.mgrid[:60, :80]
    circle = np.hypot(y - 30, x - 40) < 27
    for index, brightness in enumerate((150, 230, 150)):
        picture = cv2.resize(tissue(index, brightness), (80, 60)) * circle[..., None].astype(np.uint8)
        cv2.imwrite(str(path / f"{index}.png"), picture)
    return path


@pytest.mark.parametrize("method", ["paper", "vessel"])
@pytest.mark.parametrize("statistics", ["image", "clip"])
def test_the_surround_does_not_count_when_tissue_alone_shall(
    scope: Path, tmp_path: Path, vesselsplat: Cli, statistics: str, method: str
) -> None:
    flags = ("--pixels", "tissue", "--statistics", statistics, "--method", method, "--json")
    call = vesselsplat("enhance", scope, tmp_path / "out", *flags)
    images = [read_image(scope / f"{index}.png") for index in range(3)]
    steady = inside(images)
    pooled = measure(images, EnhanceParams(), [steady] * 3, pixels="all") if statistics == "clip" else None
    run = enhance_vessels if method == "vessel" else enhance
    summary = json.loads(call.out)
    assert summary["pixels"] == "tissue"
    for image, picture in zip(images, summary["pictures"], strict=True):
        path = tmp_path / "out" / picture["output"]
        expected = run(image, tissue_mask=inside([image]), statistics=pooled, pixels="all")
        assert np.array_equal(read_image(path), expected.image)
        assert not np.array_equal(expected.image, run(image, pixels="all").image)
        assert read_provenance(path)["pixels"] == picture["pixels"] == "tissue"


def test_one_mask_serves_all_pictures_of_a_size(scope: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    """A flash that fills the frame moves neither the mask nor what lies outside it into the statistics."""
    cv2.imwrite(str(scope / "1.png"), np.full((60, 80, 3), 255, np.uint8))
    cv2.imwrite(str(scope / "3.png"), tissue(3))
    flags = ("--pixels", "tissue", "--statistics", "clip", "--json")
    call = vesselsplat("enhance", scope, tmp_path / "out", *flags)
    images = [read_image(scope / f"{index}.png") for index in range(4)]
    steady = inside(images[:3])
    assert not steady.all()
    pooled = measure(images, EnhanceParams(), [steady, steady, steady, inside(images[3:])], pixels="all")
    assert json.loads(call.out)["pictures"][0]["statistics"]["level"] == pooled.level
    assert json.loads(call.out)["pictures"][0]["statistics"]["saturation_mean"] == pooled.saturation_mean


def test_what_is_left_out_is_as_asked(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    for limit, count in (("0", 0), ("1", 1)):
        call = vesselsplat(
            *(
                "enhance",
                folder / "1.png",
                tmp_path / "out.png",
                "--p",
                "0.001",
                "--omit-below",
                limit,
                "--json",
            )
        )
        (picture,) = json.loads(call.out)["pictures"]
        assert picture["params"]["omit_below"] == float(limit)
        assert sum("detail" in omission["what"] for omission in picture["omitted"]) == count


def test_a_clip_folder_is_its_images(clip_path: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("enhance", clip_path, tmp_path / "out", "--json")
    images = sorted(path.stem for path in (clip_path / "images").iterdir())
    assert [picture["picture"] for picture in json.loads(call.out)["pictures"]] == images


def test_a_folder_of_folders_says_which_it_holds(tmp_path: Path, vesselsplat: Cli) -> None:
    (tmp_path / "case" / "input").mkdir(parents=True)
    call = vesselsplat("enhance", tmp_path / "case", tmp_path / "out")
    assert call.code == 2
    assert "which holds the folders input: name one of these" in call.error
    assert not (tmp_path / "out").exists()
    for number in range(20):
        (tmp_path / "case" / f"of{number:02}").mkdir()
    call = vesselsplat("metrics", tmp_path / "case")
    assert "the folders input, of00, of01, of02, of03 and 16 more: name one" in call.error
    assert "or add" not in call.error, "only enhance has --recursive"


def with_maps(folder: Path) -> Path:
    """Depth and masks beside the images of a folder."""
    for index in range(3):
        depth = np.full((40, 60), 1000 + index, np.uint16)
        assert cv2.imwrite(str(folder / f"depthmap_{index}.png"), depth)
        assert cv2.imwrite(str(folder / f"{index}_mask.png"), tissue(index)[:, :, 0])
    return folder


def test_maps_beside_pictures_are_not_enhanced_and_it_is_said(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("enhance", with_maps(folder), tmp_path / "out")
    assert call.code == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["0.png", "1.png", "2.png"]
    assert "left out, depth maps beside the images: depthmap_0.png, depthmap_1.png" in call.error
    assert "left out, masks beside the images: 0_mask.png" in call.error


def test_train_and_enhance_take_the_same_pictures(folder: Path) -> None:
    with_maps(folder)
    names = [Path(label).stem for label in open_clip(folder).labels]
    assert list(open_series(folder).names) == names == ["0", "1", "2"]
    inside = folder.parent / "case"
    inside.mkdir()
    folder.rename(inside / "input")
    (inside / "mask").mkdir()
    assert list(open_series(inside).names) == [Path(label).stem for label in open_clip(inside).labels]


def test_a_batch_passes_over_folders_of_maps(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    case = tmp_path / "cases" / "one"
    case.mkdir(parents=True)
    folder.rename(case / "input")
    for name in ("mask", "depth maps"):
        (case / name).mkdir()
        cv2.imwrite(str(case / name / "0.png"), tissue(1))
    call = vesselsplat("enhance", tmp_path / "cases", tmp_path / "out", "--recursive")
    assert call.code == 0
    written = [path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.png")]
    assert sorted(written) == ["one/input/0.png", "one/input/1.png", "one/input/2.png"]
    assert "left out, masks beside the images: mask/" in call.error
    alone = vesselsplat("enhance", case / "mask", tmp_path / "alone")
    assert (alone.code, alone.error) == (0, "")


def test_two_pictures_of_one_output_name_are_refused(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    for name in ("0.jpg", "0.png.jpg"):
        cv2.imwrite(str(folder / name), tissue(9))
    call = vesselsplat("enhance", folder, tmp_path / "out")
    assert call.code == 2
    assert "0.png.jpg and 0.png" in call.error or "0.png and 0.png.jpg" in call.error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("method", ["vessel", *BASELINES])
def test_other_methods_are_those_of_the_library(
    folder: Path, tmp_path: Path, vesselsplat: Cli, method: str
) -> None:
    given, out = folder / "1.png", tmp_path / "out.png"
    assert vesselsplat("enhance", given, out, "--method", method).code == 0
    image = read_image(given)
    expected = enhance_vessels(image).image if method == "vessel" else BASELINES[method](image)
    assert np.array_equal(read_image(out), expected)
    assert read_provenance(out)["method"] == method


def test_flags_of_the_preset_reach_it(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    flags = ("--method", "vessel", "--strength", "3", "--radius", "7", "--d-factor", "0.3")
    assert vesselsplat("enhance", folder / "1.png", tmp_path / "out.png", *flags).code == 0
    params = VesselParams(strength=3, radius=7, d_factor=0.3)
    image = read_image(folder / "1.png")
    assert np.array_equal(read_image(tmp_path / "out.png"), enhance_vessels(image, params).image)
    assert read_provenance(tmp_path / "out.png")["params"]["radius"] == 7


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (("--method", "vessel", "--z", "0.3"), "--z has no effect with --method vessel"),
        (("--lift", "0.3"), "--lift has no effect with --method paper"),
        (("--method", "clahe", "--d-factor", "1"), "--d-factor has no effect with --method clahe"),
        (("--method", "clahe", "--statistics", "clip"), "--statistics clip has no effect"),
        (("--method", "clahe", "--pixels", "tissue"), "--pixels tissue has no effect"),
        (("--method", "vessel", "--omit-below", "1"), "--omit-below has no effect with --method vessel"),
        (("--pixels", "some"), "--pixels"),
        (
            ("--method", "vessel", "--strength", "9"),
            r"--strength: expected 0 to 4 for the method vessel, got 9\n",
        ),
        (
            ("--strength", "2.4"),
            r"--strength: expected 0 to 2 for the method paper, got 2.4 \(--method vessel takes up to 4\)\n",
        ),
        (("--strength", "-1"), r"--strength: expected 0 to 2 for the method paper, got -1\n"),
        (("--strength", "much"), "--strength: .*got 'much'"),
        (("--method", "tao"), "tao"),
    ],
)
def test_flags_that_do_not_fit_are_refused(
    folder: Path, tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], says: str
) -> None:
    call = vesselsplat("enhance", folder, tmp_path / "out", *flags)
    assert call.code == 2
    assert re.search(says, call.error)
    assert call.error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_other_methods_take_eight_bits_in_colour(tmp_path: Path, vesselsplat: Cli) -> None:
    cv2.imwrite(str(tmp_path / "in.png"), tissue(1).astype(np.uint16) * 257)
    call = vesselsplat("enhance", tmp_path / "in.png", tmp_path / "out.png", "--method", "clahe")
    assert call.code == 2
    assert "8-bit RGB" in call.error
    assert "in.png" in call.error


def test_clip_statistics_serve_the_preset(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    flags = ("--method", "vessel", "--statistics", "clip", "--json")
    pictures = json.loads(vesselsplat("enhance", folder, tmp_path / "out", *flags).out)["pictures"]
    assert len({picture["statistics"]["z"] for picture in pictures}) == 1
    assert pictures[0]["statistics"]["scope"] == "clip"


def test_names_that_differ_by_suffix_alone_keep_it(tmp_path: Path, vesselsplat: Cli) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    for name in ("1.png", "1.bmp", "2.png"):
        cv2.imwrite(str(folder / name), np.full((40, 50, 3), 60 + 20 * int(name[0]), np.uint8))
    assert vesselsplat("enhance", folder, out).code == 0
    assert {path.name for path in out.iterdir()} == {"1.png.png", "1.bmp.png", "2.png"}


@pytest.mark.parametrize(
    "flags", [("--deinterlacing", "field"), ("--stereo", "top-bottom"), ("--statistics", "clip")]
)
def test_flags_of_videos_are_refused_for_one_image(
    tmp_path: Path, vesselsplat: Cli, flags: tuple[str, str]
) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.full((48, 64, 3), 90, np.uint8))
    call = vesselsplat("enhance", tmp_path / "a.png", tmp_path / "b.png", *flags)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert f"{flags[0]} {flags[1]} has no effect on one image: " in call.error
    assert not (tmp_path / "b.png").exists()
    assert "no such file" in vesselsplat("enhance", tmp_path / "typo.mp4", tmp_path / "b.mp4", *flags).error


@pytest.mark.parametrize(
    ("name", "alpha", "is_lost"),
    [("a.jpg", 90, True), ("a.mp4", 90, True), ("a.png", 90, False), ("a.jpg", 255, False)],
)
def test_transparency_that_is_lost_is_told(
    tmp_path: Path, vesselsplat: Cli, name: str, alpha: int, is_lost: bool
) -> None:
    given = tmp_path / "in.png"
    assert cv2.imwrite(str(given), np.dstack((tissue(1), np.full(tissue(1).shape[:2], alpha, np.uint8))))
    call = vesselsplat("enhance", given, tmp_path / name)
    assert (call.code, "transparency is left out" in call.error) == (0, is_lost)


@pytest.mark.parametrize("name", ["out.heif", "out.heic", "out.avif"])
def test_an_output_that_cannot_be_written_is_refused_before_it_is_made(
    folder: Path, tmp_path: Path, vesselsplat: Cli, name: str
) -> None:
    for given in (folder / "1.png", folder):
        call = vesselsplat("enhance", given, tmp_path / name)
        assert (call.code, (tmp_path / name).exists()) == (2, False)
        assert "a folder, .mp4, .webm or .dcm to write, got" in call.error
