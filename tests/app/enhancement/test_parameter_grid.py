"""A grid of settings: which cells there are, that each is what the library makes, and what is refused."""

from __future__ import annotations

import csv
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.contact_sheet import columns_of, in_words
from app.enhancement.measures import METRICS, Measures
from app.enhancement.parameter_grid import Axis, axis, ranked, settings, tried
from app.errors import UserError
from app.files.image_files import read_image
from app.files.provenance import read_provenance, write_png
from enhance import EnhanceParams, enhance
from enhance.metrics import dvbv_otsu
from enhance.noise import noise_gain
from enhance.ridges import field_of_view
from enhance.vessel import VesselParams, enhance_vessels
from tests.app.conftest import Cli, tissue


def test_an_axis_is_a_range_or_a_list() -> None:
    assert axis("d_factor=0:2:5", EnhanceParams) == Axis("d_factor", (0.0, 0.5, 1.0, 1.5, 2.0))
    assert axis("d-factor=1:1:1", EnhanceParams).values == (1.0,)
    assert axis("d_factor=1:0:4", EnhanceParams).values == (1.0, 0.666667, 0.333333, 0.0)
    assert axis("d_factor=2:2:3", EnhanceParams).values == (2.0,)
    assert axis("p=auto, 0.5,0.1/0.2/0.3", EnhanceParams).values == ("auto", "0.5", ("0.1", "0.2", "0.3"))


@pytest.mark.parametrize(
    "said", ["1e-6:5e-6:9", "1e-7:9e-7:5", "1e-8:1e-7:3", "1:1.00001:400", "9e-7:1e-7:4", "1e-7:1e-7:1"]
)
def test_a_range_has_as_many_values_as_asked_for_all_of_them_in_it(said: str) -> None:
    first, last, count = (float(part) for part in said.split(":"))
    values = [float(str(value)) for value in axis(f"eps={said}", EnhanceParams).values]
    assert len(values) == count
    assert values == pytest.approx(np.linspace(first, last, int(count)).tolist(), rel=1e-5, abs=0)
    assert min(values) == min(first, last)
    assert max(values) == max(first, last)


@pytest.mark.parametrize(
    "text",
    [
        "speed=1",
        "d_factor",
        "d_factor=",
        "d_factor=0:1",
        "d_factor=0:1:1",
        "d_factor=0:x:3",
        "d_factor=0:1:0",
        "z=0:inf:3",
        "z=-1e308:1e308:3",
    ],
)
def test_a_bad_axis_is_one_line(text: str) -> None:
    with pytest.raises(UserError, match=r"--vary: expected") as caught:
        axis(text, EnhanceParams)
    assert "\n" not in str(caught.value)


def test_settings_are_every_combination_of_the_values() -> None:
    axes = [axis("p=auto,0.5", EnhanceParams), axis("d_factor=0:2:3", EnhanceParams)]
    made = settings(EnhanceParams(z=0.2), axes)
    expected = [EnhanceParams(z=0.2, p=p, d_factor=d) for p in (None, 0.5) for d in (0.0, 1.0, 2.0)]
    assert [setting.params for setting in made] == expected
    assert (made[-1].places, made[-1].label) == ((1, 2), "p 0.5 · d_factor 2")
    (joined,) = settings(EnhanceParams(), [axis("radii=4/16", EnhanceParams)])
    assert (joined.params, joined.label) == (EnhanceParams(radii=(4, 16)), "radii 4/16")


@pytest.mark.parametrize(
    "texts", [(), ("z=0:1:2", "z=0:1:3"), ("z=0:1:21", "d_factor=0:1:20"), ("z=0:2:3",), ("subsample=1:8:3",)]
)
def test_impossible_grids_are_one_line(texts: tuple[str, ...]) -> None:
    with pytest.raises(UserError, match="expected") as caught:
        settings(EnhanceParams(), [axis(text, EnhanceParams) for text in texts])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("base", [EnhanceParams(z=0.3), VesselParams(lift=0.4)])
def test_each_cell_is_what_the_library_makes_of_the_picture(base: EnhanceParams | VesselParams) -> None:
    """The shared enhancer leaves out work, never a difference."""
    image = tissue(3)
    slow = "eps=0.001,0.01" if isinstance(base, EnhanceParams) else "radius=4,9"
    wanted = settings(base, [axis("d_factor=0:2:3", type(base)), axis(slow, type(base))])
    cells = list(tried(image, wanted))
    assert {cell.setting for cell in cells} == set(wanted)
    # Cells that share what takes longest follow each other.
    shared = [cell.setting.places[1] for cell in cells]
    assert shared == sorted(shared)
    for cell in cells:
        params = cell.setting.params
        alone = (
            enhance(image, params) if isinstance(params, EnhanceParams) else enhance_vessels(image, params)
        )
        assert np.array_equal(cell.image, alone.image)
        view = field_of_view(image)
        assert cell.measures.dv_bv == dvbv_otsu(alone.image, tissue_mask=view).ratio
        np.testing.assert_equal(cell.measures.noise_gain, noise_gain(alone.image, image, tissue_mask=view))


@pytest.mark.parametrize("params", [EnhanceParams(), VesselParams()])
def test_an_image_with_alpha_is_tried_as_one_without(params: EnhanceParams | VesselParams) -> None:
    opaque = np.dstack((tissue(3), np.full(tissue(3).shape[:2], 255, np.uint8)))
    wanted = settings(params, [axis("d_factor=0,1", type(params))])
    pairs = zip(tried(opaque, wanted), tried(tissue(3), wanted), strict=True)
    for cell, other in pairs:
        assert np.array_equal(cell.image[..., :3], other.image)
        assert cell.measures.dv_bv == other.measures.dv_bv


def test_the_best_comes_first_and_what_was_not_measured_last() -> None:
    def measures(value: float) -> Measures:
        return Measures(**dict.fromkeys(METRICS, value))

    cells = [measures(value) for value in (1.0, math.nan, 3.0, 2.0)]
    assert ranked(cells, "vessel_contrast") == [2, 3, 0, 1]
    assert ranked(cells, "noise_gain") == [0, 3, 2, 1]


def test_two_axes_in_order_are_rows_and_columns() -> None:
    assert columns_of([3, 5], in_order=True) == 5
    assert columns_of([3, 5], in_order=False) == 4
    assert columns_of([1], in_order=True) == 1


def test_the_command_writes_pictures_sheet_and_tables(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    out = tmp_path / "out"
    flags = ("--vary", "d_factor=0:2:2", "--vary", "p=auto,0.5", "--frame", 1, "--z", "0.3", "--json")
    call = vesselsplat("tune", folder, "--out", out, *flags)
    assert call.code == 0, call.error
    report = json.loads(call.out)
    assert report == json.loads((out / "tuning.json").read_text())
    assert [cell["label"] for cell in report["cells"]][:2] == ["d_factor 0 · p auto", "d_factor 0 · p 0.5"]
    for cell in report["cells"]:
        params = EnhanceParams(**cell["params"])
        assert params.z == 0.3
        assert np.array_equal(
            read_image(out / cell["output"]), enhance(read_image(folder / "1.png"), params).image
        )
    rows = list(csv.DictReader((out / "tuning.csv").read_text().splitlines()))
    assert [row["d_factor"] for row in rows] == ["0.0", "0.0", "2.0", "2.0"]
    assert [float(row["dv_bv"]) for row in rows] == [cell["dv_bv"] for cell in report["cells"]]
    assert str(tmp_path) not in json.dumps(report) + json.dumps(read_provenance(out / "sheet.png"))
    sheet = read_provenance(out / "sheet.png")
    assert sheet["title"] == "1.png: Colour, Detail"
    assert [cell["label"] for cell in sheet["settings"]][1:3] == [
        "Colour 0.00 · Detail 0.5", "Colour 0.33 · Detail auto"
    ]  # fmt: skip
    for name in ("sheet.png", "setting-003.png"):
        again = vesselsplat("replay", out / name, "--source", folder)
        assert (again.code, again.error) == (0, "")


def test_sorted_cells_keep_their_pictures(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    flags = ("--method", "vessel", "--vary", "strength=0:4:3", "--sort", "saturated_share", "--json")
    call = vesselsplat("tune", folder / "2.png", "--out", tmp_path / "out", *flags)
    cells = json.loads(call.out)["cells"]
    shares = [cell["saturated_share"] for cell in cells]
    assert shares == sorted(shares)
    for cell in cells:
        made = read_provenance(tmp_path / "out" / cell["output"])
        assert made["params"] == cell["params"]
    assert vesselsplat("replay", tmp_path / "out" / "sheet.png", "--source", folder).code == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no file has such a name there")
def test_a_name_of_two_lines_is_one_in_the_title(folder: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    path = (folder / "2.png").rename(folder / "2\n3.png")
    call = vesselsplat("tune", path, "--out", tmp_path / "out", "--vary", "d_factor=0")
    assert (call.code, call.error) == (0, "")
    assert vesselsplat("replay", tmp_path / "out" / "sheet.png", "--source", folder).code == 0


def test_what_cannot_be_measured_is_none_as_in_metrics(tmp_path: Path, vesselsplat: Cli) -> None:
    write_png(tmp_path / "flat.png", np.full((24, 32, 3), 90, np.uint8), {})
    call = vesselsplat("tune", tmp_path / "flat.png", "--out", tmp_path / "out", "--vary", "d_factor=0")
    assert (call.code, call.error, "tuning.json and 1 image\n" in call.out) == (0, "", True)
    assert " none " in call.out
    assert "nan" not in call.out.split()
    undefined = Measures(**dict.fromkeys(METRICS, math.nan))
    assert in_words(undefined) == "DV/BV none · contrast none · noise gain none"
    sheet = tmp_path / "out" / "sheet.png"
    facts = read_provenance(sheet)
    replayed = vesselsplat("replay", sheet, "--source", tmp_path / "flat.png")
    assert (facts["undefined"], replayed.out.rstrip()[-9:]) == ("none", "identical")
    del facts["undefined"]
    write_png(sheet, read_image(sheet), facts)
    before = vesselsplat("replay", sheet, "--source", tmp_path / "flat.png")
    assert before.out.rstrip()[-9:] != "identical", "it said nan"


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--vary", "speed=1:2:3"), "expected one of z, p"),
        (("--vary", "z=0:2:3"), "z: expected"),
        (("--vary", "z=0:1:3", "--frame", "7"), "--frame"),
        (("--vary", "z=0:1:3", "--lift", "0.3"), "--lift"),
        (("--vary", "d-factor=0,2", "--d-factor", "1"), "expected d_factor to be varied or fixed, got both"),
        ((), "--vary"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(
    folder: Path, tmp_path: Path, vesselsplat: Cli, flags: tuple[str, ...], said: str
) -> None:
    call = vesselsplat("tune", folder, "--out", tmp_path / "out", *flags)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert said in call.error
    assert not (tmp_path / "out").exists()


def test_pictures_of_before_are_told_and_none_of_them_is_overwritten_as_input(
    folder: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    out = tmp_path / "out"
    assert vesselsplat("tune", folder / "0.png", "--out", out, "--vary", "d_factor=0:2:3").error == ""
    call = vesselsplat("tune", folder / "0.png", "--out", out, "--vary", "d_factor=0,2")
    assert (call.code, call.error) == (0, f"{out} also holds 1 file of these kinds from before\n")
    first = out / "setting-000.png"
    before = first.read_bytes()
    for source in (first, out):
        call = vesselsplat("tune", source, "--out", out, "--vary", "d_factor=0,2")
        assert (call.code, call.error.count("\n")) == (2, 1)
        assert "--out: expected another folder than that of INPUT" in call.error
    assert first.read_bytes() == before
