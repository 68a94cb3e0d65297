"""Files of 10 and 12 bits in 16 are enhanced and measured as the window shows them, and say so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from app.exports.records import PanesPicture
from app.exports.replay.again import replay
from app.files.image_files import read_image, write_image
from app.files.image_series import open_series
from app.files.provenance import read_provenance
from app.files.records import RecordedReading
from enhance import enhance_vessels
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_files.used_bits import stretched
from renderer.sources import open_clip
from tests.app.conftest import Cli, tissue
from tests.renderer.readers.test_used_bits import write


def frame(most: int, share: float = 1.0) -> NDArray[np.uint16]:
    """(40, 60, 3) RGB tissue whose brightest value is `share` of the most that these bits hold."""
    image = tissue(0)[..., ::-1].astype(np.float64)
    return np.rint(share * most * image / image.max()).astype(np.uint16)


def test_vessel_is_that_of_the_whole_range_and_comes_again(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = write(tmp_path / "a.png", frame(1023)), tmp_path / "out.png"
    call = vesselsplat("enhance", given, out, "--method", "vessel")
    assert call.code == 0
    assert "16-bit file that uses 10 bits: shown 64 times brighter" in call.error
    assert np.array_equal(read_image(out), enhance_vessels(stretched(read_image(given), 10)).image)
    assert read_provenance(out)["bits"] == 10
    assert replay(out, (), tmp_path / "again.png").difference.is_none


def test_as_stored_where_that_is_asked_for(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = write(tmp_path / "a.png", frame(1023)), tmp_path / "out.png"
    call = vesselsplat("enhance", given, out, "--method", "vessel", "--bits", "16")
    assert (call.code, call.error.count("brighter")) == (0, 0)
    assert np.array_equal(read_image(out), enhance_vessels(read_image(given)).image)
    assert replay(out, (), tmp_path / "again.png").difference.is_none


def test_what_was_made_before_is_of_what_was_stored(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = write(tmp_path / "a.png", frame(1023)), tmp_path / "out.png"
    assert vesselsplat("enhance", given, out, "--bits", "16").code == 0
    told = read_provenance(out)
    del told["bits"]
    write_image(out, read_image(out), told)
    assert replay(out, (), tmp_path / "again.png").difference.is_none


def test_a_dark_frame_is_made_again_with_the_bits_of_its_folder(tmp_path: Path, vesselsplat: Cli) -> None:
    folder = tmp_path / "clip"
    folder.mkdir()
    for number, share in enumerate((1.0, 0.2)):
        write(folder / f"{number}.png", frame(4095, share))
    call = vesselsplat("enhance", folder, tmp_path / "out", "--method", "vessel")
    assert call.code == 0
    assert call.error.count("16-bit files that use 12 bits: shown 16 times brighter") == 1
    assert read_provenance(tmp_path / "out/1.png")["bits"] == 12
    assert replay(tmp_path / "out/1.png", (folder,), tmp_path / "again.png").difference.is_none


def test_window_and_commands_read_the_same(tmp_path: Path) -> None:
    image = np.dstack((frame(1023), np.full((40, 60), 40000, np.uint16)))
    write(tmp_path / "a.png", image)
    series, clip = open_series(tmp_path / "a.png"), open_clip(tmp_path / "a.png")
    assert np.abs(series.read(0)[..., :3] / 257 - clip.read_image(0)).max() <= 0.5
    assert (series.read(0)[..., 3] == 40000).all()
    assert series.notices == clip.notices


def test_measures_are_of_what_is_shown(tmp_path: Path, vesselsplat: Cli) -> None:
    deep, whole = write(tmp_path / "a.png", frame(1023)), tmp_path / "b.png"
    write(whole, stretched(frame(1023), 10))
    calls = [vesselsplat("metrics", path, "--json") for path in (deep, whole)]
    assert [call.error.count("that uses 10 bits") for call in calls] == [1, 0]
    own, same = (json.loads(call.out)["mean"] for call in calls)
    assert own == same


def test_a_tuning_sheet_comes_again(tmp_path: Path, vesselsplat: Cli) -> None:
    given, out = write(tmp_path / "a.png", frame(1023)), tmp_path / "out"
    call = vesselsplat("tune", given, "--vary", "d_factor=0:1:2", "--out", out)
    assert (call.code, "uses 10 bits" in call.error) == (0, True)
    for name in ("sheet.png", "setting-001.png"):
        assert read_provenance(out / name)["bits"] == 10
        assert replay(out / name, (given,), tmp_path / name).difference.is_none


def test_records_of_before_read_what_is_stored() -> None:
    read = TypeAdapter(RecordedReading).validate_python
    assert read({"frame_step": 2}) == ClipOptions(frame_step=2, bits=16, alpha="ignored")
    assert read({"bits": None}).bits is None
    assert read({"bits": 12}).bits == 12
    panes = TypeAdapter(PanesPicture).validate_python({"clip_options": {"depth": "off"}})
    assert panes.clip_options.bits == 16
