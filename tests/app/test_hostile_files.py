"""Files that claim gigabytes, hang whoever reads them, or are nested without end: one line each, at once."""

from __future__ import annotations

import gzip
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from app.__main__ import main
from app.files.embedded import KEYWORD
from app.gui.work.presets import load_presets
from app.gui.work.settings import load_settings
from app.report.section import read_report
from app.runs.queue_file import take_over
from app.runs.run_folder import RunFolder
from renderer.view_files import FORMAT, VERSION
from tests.app.apart import Call, called
from tests.app.conftest import ROOT, Cli

BRACKETS = b"[" * 100_000
SECONDS = 20


def one_line(call: Call) -> str:
    assert call.code == 2, call.error
    assert call.error.startswith("vesselsplat: ")
    assert call.error.count("\n") == 1
    assert "Traceback" not in call.error
    return call.error


def chunk(kind: bytes, content: bytes, claimed: int | None = None) -> bytes:
    """That claims to be as long as it is, unless told otherwise."""
    length = len(content) if claimed is None else claimed
    return struct.pack(">I", length) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def write_png(path: Path, *chunks: bytes) -> Path:
    """8x8 pixels in RGB: what stands between the header and the end."""
    header = struct.pack(">IIBBBBB", 8, 8, 8, 2, 0, 0, 0)
    parts = (b"\x89PNG\r\n\x1a\n", chunk(b"IHDR", header), *chunks, chunk(b"IEND", b""))
    path.write_bytes(b"".join(parts))
    return path


ROWS = zlib.compress(bytes(8 * 25))


def with_little_memory(arguments: list[str]) -> int:
    """The command, which may take three gigabytes more than it has."""
    import resource

    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (3 << 30),) * 2)
    return main(arguments)


@pytest.mark.skipif(sys.platform != "linux", reason="limits memory as Linux does")
@pytest.mark.parametrize("command", [["info"], ["metrics"], ["enhance"]], ids=str)
def test_a_chunk_that_claims_four_gigabytes_is_a_damaged_file(tmp_path: Path, command: list[str]) -> None:
    """Pillow reads what is left of the last chunk of pixels at once, and raises MemoryError."""
    picture = write_png(tmp_path / "a.png", chunk(b"IDAT", ROWS, claimed=0xFFFFFFFF))
    out = ["out.png"] if command == ["enhance"] else []
    said = one_line(called(with_little_memory, [*command, str(picture), *out], folder=tmp_path, seconds=60))
    assert "header makes no sense" in said
    assert str(picture) in said


@pytest.mark.parametrize("command", [["info"], ["metrics"], ["enhance"]], ids=str)
def test_a_colour_profile_of_no_bytes_after_the_pixels(
    tmp_path: Path, vesselsplat: Cli, command: list[str]
) -> None:
    """Pillow raises IndexError."""
    picture = write_png(tmp_path / "a.png", chunk(b"IDAT", ROWS), chunk(b"iCCP", b""))
    out = [tmp_path / "out.png"] if command == ["enhance"] else []
    assert str(picture) in one_line(vesselsplat(*command, picture, *out))


def huge_png(path: Path, side: int = 13_000) -> Path:
    """Half a megabyte of zeros that decode to half a gigabyte."""
    packer, rows = zlib.compressobj(9), b""
    for _ in range(side):
        rows += packer.compress(bytes(1 + 3 * side))
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", rows + packer.flush()), (b"IEND", b"")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts))
    return path


@pytest.mark.parametrize("command", [("info",), ("enhance",), ("metrics",)])
def test_a_small_picture_of_13000_squared_is_refused_by_its_header(
    tmp_path: Path, vesselsplat: Cli, command: tuple[str, ...]
) -> None:
    picture = huge_png(tmp_path / "huge.png")
    assert picture.stat().st_size < 1 << 20
    out = [tmp_path / "out.png"] if command == ("enhance",) else []
    said = one_line(vesselsplat(*command, picture, *out))
    assert "expected at most 80000000 pixels (VESSELSPLAT_MOST_PIXELS sets the limit), got 169000000" in said
    assert str(picture) in said


@pytest.mark.parametrize("suffix", ["png", "jpg", "tif", "webp", "bmp", "ppm", "npy"])
def test_every_format_is_held_to_the_budget_that_is_set(
    tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    path, image = tmp_path / f"picture.{suffix}", np.zeros((48, 64, 3), np.uint8)
    if suffix == "npy":
        np.save(path, image)
    else:
        Image.fromarray(image).save(path)
    assert vesselsplat("enhance", path, tmp_path / "before.png").code == 0
    monkeypatch.setenv("VESSELSPLAT_MOST_PIXELS", "3071")
    said = one_line(vesselsplat("enhance", path, tmp_path / "out.png"))
    assert "VESSELSPLAT_MOST_PIXELS" in said
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("said", ["many", "-1", "1e6", "²"])
def test_a_budget_that_is_no_number_is_a_mistake_in_one_line(
    tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch, said: str
) -> None:
    Image.new("RGB", (64, 48)).save(tmp_path / "a.png")
    monkeypatch.setenv("VESSELSPLAT_MOST_PIXELS", said)
    assert "VESSELSPLAT_MOST_PIXELS" in one_line(vesselsplat("info", tmp_path / "a.png"))


def test_a_packed_file_that_claims_ten_million_splats_is_refused(tmp_path: Path, vesselsplat: Cli) -> None:
    head = struct.pack("<IIIBBBB", 0x5053474E, 2, 9_999_999, 0, 12, 0, 0)
    (tmp_path / "a.spz").write_bytes(gzip.compress(head + bytes(1 << 20)))
    said = one_line(vesselsplat("render", tmp_path / "a.spz", "--out", tmp_path / "out"))
    assert "5000000 splats" in said


@pytest.mark.parametrize(
    "header",
    [
        "element vertex 1000000000000\nproperty float x\n",
        "element vertex 1000000000000\n",
        "element vertex -5\nproperty float x\n",
        "element face 1000000000000\nproperty list uchar int vertex_indices\n",
    ],
)
def test_headers_that_claim_more_rows_than_the_file_has(
    tmp_path: Path, vesselsplat: Cli, header: str
) -> None:
    (tmp_path / "a.ply").write_bytes(f"ply\nformat binary_little_endian 1.0\n{header}end_header\n".encode())
    one_line(vesselsplat("render", tmp_path / "a.ply", "--out", tmp_path / "out"))


@pytest.fixture
def run(runs: dict[str, Path], tmp_path: Path) -> RunFolder:
    """A copy."""
    shutil.copytree(runs["original"], tmp_path / "run")
    return RunFolder(tmp_path / "run")


def recorded(run: RunFolder, **clip: object) -> None:
    """Write other facts about the clip into run.json."""
    path = run.path / "run.json"
    record = json.loads(path.read_text())
    record["clip"] |= clip
    path.write_text(json.dumps(record).replace("Infinity", "1e999"))


@pytest.mark.parametrize(
    "facts",
    [
        {"frames": 100_000_000},
        {"frames": 0},
        {"frames": -3},
        {"cameras": []},
        {"cameras": [{"fx": 1e-300}]},
        {"cameras": [[1, 2], None]},
        {"cameras": {}},
        {"frames_per_second": float("inf")},
    ],
)
def test_a_run_of_impossible_frames_and_cameras(
    run: RunFolder, vesselsplat: Cli, tmp_path: Path, facts: dict[str, object]
) -> None:
    recorded(run, **facts)
    for command in (["info", run.path], ["render", run.path, "--out", tmp_path / "out"]):
        assert "run.json" in one_line(vesselsplat(*command))


@pytest.mark.parametrize(("name", "value"), [("fx", 1e-300), ("fy", 0.0), ("fx", -5.0), ("width", 10**9)])
def test_a_camera_that_is_none_is_refused_wherever_it_stands(
    run: RunFolder, vesselsplat: Cli, tmp_path: Path, name: str, value: float
) -> None:
    camera = run.record().cameras[0].to_json() | {name: value}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    flags = ["--camera", tmp_path / "camera.json", "--frames", "0"]
    one_line(vesselsplat("render", run.path, "--out", tmp_path / "out", *flags))
    recorded(run, cameras=[camera])
    one_line(vesselsplat("render", run.path, "--out", tmp_path / "out", "--frames", "0"))


def test_a_camera_path_of_months_is_refused(run: RunFolder, vesselsplat: Cli, tmp_path: Path) -> None:
    camera = run.record().cameras[0].to_json()
    keys = [{"seconds": seconds, "time": 0.5, "camera": camera} for seconds in (0, 1e5)]
    views = {"format": FORMAT, "version": VERSION, "views": [], "path": {"loop": False, "keyframes": keys}}
    (tmp_path / "path.json").write_text(json.dumps(views))
    flags = ["--path", tmp_path / "path.json"]
    said = one_line(vesselsplat("render", run.path, "--out", tmp_path / "out", *flags))
    assert "3600 seconds" in said


@pytest.mark.parametrize(
    "line",
    [
        b'{"event": "Finished"}',
        b'{"event": "Started", "omitted": 5}',
        b'{"event": "Started", "omitted": [{"what": 1}]}',
        b'{"event": "Progress", "psnr": "high"}',
        b'{"event": "Evaluated", "iteration": 5, "psnr": "high"}',
        b'{"event": "Evaluated", "iteration": 5, "psnr": true}',
        b'{"event": "Progress", "iteration": 1e300, "n_gaussians": []}',
        b'{"event": "Warned"}',
        b'{"event": ["Finished"]}',
        b"[1]",
        BRACKETS,
    ],
)
def test_a_log_without_its_fields_is_passed_over(run: RunFolder, vesselsplat: Cli, line: bytes) -> None:
    with (run.path / "events.jsonl").open("ab") as file:
        file.write(b"\n" + line + b"\n")
    call = vesselsplat("info", run.path)
    assert (call.code, call.error) == (0, "")
    call = vesselsplat("train", run.record().clip.path, "--run", run.path, "--resume")
    assert "Traceback" not in call.error


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("provenance", None),
        ("session.vesselsplat", BRACKETS),
        ("out.mp4.json", BRACKETS),
        ("path.json", BRACKETS),
    ],
)
def test_a_hundred_thousand_brackets_are_one_line(
    run: RunFolder, tmp_path: Path, vesselsplat: Cli, name: str, content: bytes | None
) -> None:
    if content is None:
        text = PngInfo()
        text.add_itxt(KEYWORD, BRACKETS.decode())
        Image.new("RGB", (8, 8)).save(tmp_path / "a.png", pnginfo=text)
        one_line(vesselsplat("replay", tmp_path / "a.png"))
        return
    (tmp_path / name).write_bytes(content)
    if name == "path.json":
        one_line(vesselsplat("render", run.path, "--out", tmp_path / "o", "--path", tmp_path / name))
    elif name == "out.mp4.json":
        (tmp_path / "out.mp4").write_bytes(b"no video")
        one_line(vesselsplat("replay", tmp_path / "out.mp4"))
    else:
        one_line(vesselsplat("info", tmp_path / name))


@pytest.mark.parametrize("content", [BRACKETS, b"NaN", b"\xff\xfe", b"{", b"0" * 10_000])
def test_own_files_that_are_damaged_never_raise(tmp_path: Path, content: bytes) -> None:
    for name, read in (
        ("settings.json", load_settings),
        ("presets.json", load_presets),
        ("queue-1.json", take_over),
    ):
        (tmp_path / name).write_bytes(content)
        read(tmp_path / name)


def test_a_report_of_brackets_is_a_value_error_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "report.json").write_bytes(BRACKETS)
    with pytest.raises(Exception, match=re.escape("report.json")) as told:
        read_report(tmp_path / "report.json")
    assert "\n" not in str(told.value)


WIDTH_ENTRY = struct.pack("<HHI", 256, 4, 1)
"""Tag, type and count in the directory of a page of a TIFF."""


def write_without_last_width(path: Path, pages: int) -> None:
    """Of the last of so many pages."""
    page = Image.new("RGB", (64, 48))
    page.save(path, save_all=True, append_images=[page] * (pages - 1))
    before, after = path.read_bytes().rsplit(WIDTH_ENTRY, 1)
    path.write_bytes(before + b"\xe7\x03" + WIDTH_ENTRY[2:] + after)


@pytest.mark.parametrize("command", [["info"], ["enhance"]], ids=str)
def test_a_tiff_without_a_width_is_refused_in_one_line(
    tmp_path: Path, vesselsplat: Cli, command: list[str]
) -> None:
    write_without_last_width(tmp_path / "a.tif", pages=1)
    more = [tmp_path / "out.png"] if command == ["enhance"] else []
    said = one_line(vesselsplat(*command, tmp_path / "a.tif", *more))
    assert "a.tif" in said
    assert not (tmp_path / "out.png").exists()


def test_a_damaged_second_page_does_not_keep_the_first_from_being_read(
    tmp_path: Path, vesselsplat: Cli
) -> None:
    """Pillow raises TypeError when it counts the pages."""
    write_without_last_width(tmp_path / "a.tif", pages=2)
    call = vesselsplat("enhance", tmp_path / "a.tif", tmp_path / "out.png")
    assert call.code == 0
    assert (tmp_path / "out.png").is_file()


def test_libraries_do_not_warn_past_our_own_lines(tmp_path: Path) -> None:
    """The picture's tag makes Pillow warn."""
    Image.new("RGB", (64, 48)).save(tmp_path / "a.tif", tiffinfo={270: "text"})
    content = bytearray((tmp_path / "a.tif").read_bytes())
    at = content.find(struct.pack("<HH", 270, 2))
    content[at + 4 : at + 8] = struct.pack("<I", 0x7FFFFFFF)
    (tmp_path / "a.tif").write_bytes(bytes(content))
    done = subprocess.run(
        [sys.executable, "-m", "app", "info", str(tmp_path / "a.tif")],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=SECONDS,
        check=False,
    )  # fmt: skip
    assert "Warning" not in done.stderr
