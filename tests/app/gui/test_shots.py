"""Exports of the window: the pixels are the panes' own, each is made again, and none stands in the way."""

from __future__ import annotations

import csv
import errno
import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.image_mask import PictureMask
from app.enhancement.measures import METRICS
from app.exports.comparison_images import DifferenceRequest, heat_map
from app.exports.exporting import ExportRequest, export
from app.exports.records import PanesPicture
from app.exports.sizing import Sizing
from app.files.image_files import read_image
from app.files.provenance import plain, read_provenance, write_png
from app.gui.actions import actions, comparing, enhancement_actions, export_actions
from app.gui.actions.export_offers import OFFERS
from app.gui.commands.keys import chord
from app.gui.panels.export import draw_export
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from app.gui.views.comparison import SIDES
from app.gui.work.settings import Places
from app.runs.clip_selection import ClipPart
from app.scenes.color_bar import LEAST_HEIGHT
from assets import phantom_path
from enhance import EnhanceParams
from enhance.metrics import dvbv_otsu
from tests.app.conftest import Cli
from tests.app.gui.conftest import SIZE
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.exporting import Exporter, same
from tests.app.gui.ui import Ui

FOOT = 28
"""Pixels below a small picture, for the notice."""


def test_a_pane_is_what_it_shows_at_the_size_asked_for(run: Exporter, clip_path: Path) -> None:
    state = run.state
    comparing.store(state, "A")
    enhancement_actions.set_params(state, EnhanceParams(d_factor=0.2))
    state.enhancement.scope, state.enhancement.pixels, state.exports.sizing = "clip", "tissue", Sizing(3)
    for source in ("original", "enhanced", "A", "clahe", "render"):
        comparing.choose_source(state, "left", source)
        run.rest()
        assert state.picture.pictures is not None
        shown = pane(state, state.picture.pictures, "left").image
        path = run.made("left pane")
        page = read_image(path)
        height, width = shown.shape[:2]
        top = (page.shape[0] - 3 * height) // 2
        inside = page[top : top + 3 * height, : 3 * width]
        np.testing.assert_array_equal(inside, shown.repeat(3, axis=0).repeat(3, axis=1))
        assert same(path, clip_path, Path(str(state.runs.reconstruction.run_path)))
        facts = read_provenance(path)
        assert str(clip_path) not in json.dumps(facts)


def test_the_pair_and_its_video_come_again(run: Exporter, clip_path: Path) -> None:
    state, run_path = run.state, run.state.runs.reconstruction.run_path
    assert run_path is not None
    comparing.choose_source(state, "left", "enhanced")
    comparing.choose_source(state, "right", "render")
    actions.seek(state, 4)
    assert same(run.made("both panes"), clip_path, run_path)
    video = run.made("video of both panes")
    capture = cv2.VideoCapture(str(video))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 10
    capture.release()
    assert same(video, clip_path, run_path)


def test_the_right_pane_alone_is_a_video_whatever_the_mode(run: Exporter, clip_path: Path) -> None:
    size = read_image(run.made("right pane")).shape
    comparing.choose_mode(run.state, mode="wipe")
    video = run.made("video of the right pane")
    facts = json.loads(video.with_name(f"{video.name}.json").read_text())
    assert [pane["title"] for pane in facts["panes"]] == ["Enhanced"]
    capture = cv2.VideoCapture(str(video))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 10
    width, height = (capture.get(name) for name in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    capture.release()
    assert abs(width - size[1]) <= 1  # Of video, sides are even.
    assert abs(height - size[0]) <= 1
    assert same(video, clip_path)


def test_a_changed_pane_is_found_out(run: Exporter, clip_path: Path) -> None:
    path = run.made("right pane")
    facts = read_provenance(path)
    facts["panes"][0]["params"]["d_factor"] = 2.0
    write_png(path, read_image(path), facts)
    assert not same(path, clip_path)


def test_measures_are_of_every_pane_and_frame(run: Exporter) -> None:
    path = run.made("measures of both panes")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert [(row["frame"], row["pane"]) for row in rows[:3]] == [
        ("0", "Original"),
        ("0", "Enhanced"),
        ("1", "Original"),
    ]
    assert len(rows) == 20
    assert run.state.source.clip is not None
    assert float(rows[2]["dv_bv"]) == dvbv_otsu(run.state.source.clip.read_image(1)).ratio
    assert {row["noise_gain"] for row in rows if row["pane"] == "Original"} == {"1.0"}
    facts = json.loads(path.with_name(f"{path.name}.json").read_text())
    assert [row["dv"] for row in facts["frames"]] == [float(row["dv"]) for row in rows]
    assert set(METRICS) - {"milliseconds"} <= facts["frames"][0].keys()
    assert facts["panes"][1]["params"] == plain(EnhanceParams())


def test_the_table_comes_again_and_a_changed_number_is_found_out(
    run: Exporter, clip_path: Path, vesselsplat: Cli
) -> None:
    path = run.made("measures of both panes")
    assert same(path, clip_path)
    sidecar = path.with_name(f"{path.name}.json")
    call = vesselsplat("replay", sidecar)
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert path.name in call.error
    before = path.read_text()
    path.write_text(before.replace(",1.0,", ",1.001,", 1))
    assert not same(path, clip_path)
    path.write_text(before)
    facts = json.loads(sidecar.read_text())
    facts["frames"][3]["dv"] += 0.5
    sidecar.write_text(json.dumps(facts))
    assert not same(path, clip_path)


def test_panes_come_again_as_they_were_compared(run: Exporter, clip_path: Path) -> None:
    """Wipe, difference, flip and a width in pixels; masked and trimmed."""
    state = run.state
    state.source.part = ClipPart(mask=PictureMask(text=(0, 0, 30, 20)), trim=(2, 7))
    state.enhancement.scope, state.comparing.wiped = "clip", 0.25
    run.rest()
    assert state.picture.pictures is not None
    left, right = (pane(state, state.picture.pictures, side).image for side in SIDES)
    assert not np.array_equal(left, right)

    comparing.choose_mode(state, "wipe")
    page = read_image(wiped := run.made("panes as shown"))
    height, width = left.shape[:2]
    inside = page[-FOOT - height : -FOOT]
    np.testing.assert_array_equal(inside[:, : width // 4], left[:, : width // 4])
    np.testing.assert_array_equal(inside[:, 1 + width // 4 : width + 1], right[:, width // 4 :])
    assert same(wiped, clip_path)

    comparing.choose_mode(state, "flip")
    flipped = read_image(run.made("panes as shown"))
    inside = flipped[-FOOT - height : -FOOT, :width]
    np.testing.assert_array_equal(inside, left if state.comparing.chosen.flipped else right)

    comparing.choose_mode(state, "difference")
    state.exports.sizing = Sizing(width=100)
    run.turn(6)
    assert same(run.made("panes as shown"), clip_path)
    state.exports.sizing = Sizing()
    (heat,) = heat_map(DifferenceRequest(left, right))
    page = read_image(run.made("panes as shown"))
    np.testing.assert_array_equal(page[-FOOT - LEAST_HEIGHT :][:height, :width], heat.heat)
    video = run.made("video of the panes")
    assert json.loads(video.with_name(f"{video.name}.json").read_text())["arrangement"]["top"] == heat.top
    assert same(video, clip_path)
    capture = cv2.VideoCapture(str(video))
    assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 6
    capture.release()
    table = run.made("measures of both panes")
    assert [row["frame"] for row in csv.DictReader(table.read_text().splitlines())][::2] == list("234567")
    assert same(table, clip_path)


def test_s_saves_what_the_panes_show(run: Exporter, clip_path: Path) -> None:
    state, run_path = run.state, run.state.runs.reconstruction.run_path
    assert run_path is not None
    comparing.choose_source(state, "left", "clahe")
    comparing.choose_mode(state, "wipe")
    export_actions.save_picture(state)
    (request,), state.window.wishes = state.window.wishes, ()
    assert isinstance(request, ExportRequest)
    assert isinstance(request.record, PanesPicture)
    assert (request.record.arrangement.mode, request.record.panes[0].method) == ("wipe", "clahe")
    *_, last = export(request)
    assert last.path is not None
    facts = read_provenance(last.path)
    assert [one["shows"] for one in facts["panes"]] == ["method", "setting"]
    assert facts["views"][0]["run"]["name"] == run_path.name
    assert same(last.path, clip_path, run_path)
    state.enhancement.peeking = True
    export_actions.save_picture(state)
    (request,), state.window.wishes = state.window.wishes, ()
    assert isinstance(request, ExportRequest)
    assert isinstance(request.record, PanesPicture)
    assert [pane.shows for pane in request.record.panes] == ["original"]


def test_sliders_are_served_while_a_video_is_made_and_cancel_leaves_nothing(run: Exporter) -> None:
    run.begin("video of both panes")
    while run.state.exports.done == 0:
        run.turn(1)
    exporting = run.state.exports.under_way
    assert exporting is not None
    assert 0 < run.state.exports.done < 10
    assert export_actions.why_not_export(run.state, "left pane")
    enhancement_actions.set_params(run.state, EnhanceParams(z=0.4))
    run.turn(3)
    assert run.state.picture.pictures is not None
    assert run.state.picture.pictures.request == run.state.picture_request
    assert run.state.exports.under_way is exporting
    run.channels.exports.want(None)
    export_actions.cancelled(run.state)
    path = run.made("left pane")  # Asked for before the worker has heard of the end.
    assert sorted(run.state.places.pictures.iterdir()) == [path]


def test_a_full_disk_is_a_sentence_and_leaves_nothing(run: Exporter, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("app.files.atomic.os.fsync", full)
        for what in ("both panes", "video of both panes", "measures of both panes"):
            run.begin(what)
            run.turn(30)
            assert run.state.window.banner is not None
            said = "the export failed: No space left on device: "
            assert run.state.window.banner.message.startswith(said)
            run.state.window.banner = None
    assert run.state.exports.under_way is None
    assert list(run.state.places.pictures.glob("*")) == []


def test_what_is_lacking_is_said(places: Places) -> None:
    state = AppState(places)
    assert {export_actions.why_not_export(state, what) for what in OFFERS if what != "window"} == {
        "Open a clip first.", "There is no 3D model yet: reconstruct the clip or open a run.",
    }  # fmt: skip
    assert export_actions.export_request(state, "left pane") is None
    export_actions.save_picture(state)
    assert state.window.wishes == ()


def test_the_panel_draws(ui: Ui, state: AppState) -> None:
    state.exports.shown = True
    for _ in range(2):
        ui.frame(lambda: draw_export(state))
    request = export_actions.export_request(state, "both panes")
    assert request is not None
    heights = []
    for state.exports.under_way in (None, request):
        for _ in range(3):
            ui.frame(lambda: draw_export(state))
        heights.append(imgui.internal.find_window_by_name("Export").size.y)
    assert heights[0] == heights[1]  # No button moves away from the pointer that started it.
    assert state.exports.shown
    assert SIZE == (48, 40)


@pytest.mark.display
def test_from_the_key_to_the_file(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(chord("Ctrl+Shift+E"))
        ctx.yield_(2)
        ctx.item_click("//Export/**/###both panes")
        ctx.item_click("//Export/**/###start")
        wait(ctx, lambda: state.exports.under_way is None and state.window.toast is not None, "the picture")
        ctx.item_click("//Export/**/###video of both panes")
        ctx.item_double_click("//Export/**/###start")  # Of which the second click cancels nothing.
        wait(
            ctx,
            lambda: state.exports.under_way is not None and state.exports.done > 1,
            "some frames",
        )
        ctx.item_click("//Export/**/Cancel")
        wait(ctx, lambda: state.exports.under_way is None, "the end")

    driver.run(drive)
    (path,) = places.pictures.glob("*.png")
    assert same(path)
