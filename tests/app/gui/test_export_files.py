"""Exports as files: names and folders, formats of images, the panel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.enhancement.enhance_files import Setting
from app.exports.exporting import ExportRequest, free_name
from app.exports.replay.again import replay
from app.files.image_files import read_image, write_image
from app.files.provenance import read_provenance
from app.files.video_encoder import VideoEncoder
from app.gui.actions import actions, closing, export_actions, floating_windows
from app.gui.actions.export_names import default_name, why_not_name
from app.gui.actions.export_offers import OFFERS
from app.gui.commands.commands import sections
from app.gui.commands.finding import find
from app.gui.commands.keys import chord
from app.gui.panels import menus
from app.gui.panels.export import draw_export
from app.gui.state.app_state import AppState
from app.gui.state.reconstruction import Waiting
from app.gui.work.batching import BatchRequest
from app.gui.work.naming import NameRequest
from app.gui.work.settings import Places
from app.runs.train_run import TrainRequest
from assets import phantom_path
from enhance.vessel import VesselParams
from renderer.train.config import TrainConfig
from tests.app.gui.conftest import outside
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.exporting import Exporter, exported, same
from tests.app.gui.test_session import opened_state
from tests.app.gui.ui import Ui

# ---- names and folders


def test_a_name_says_clip_frame_and_what_it_is(run: Exporter) -> None:
    state = run.state
    actions.seek(state, 4)
    said = {what: default_name(state, what) for what in OFFERS}
    assert said["panes and 3D view"] == "small-frame-5"
    assert said["left pane"] == "small-frame-5-left"
    assert said["video of both panes"] == "small-frames-1-10-both"
    assert said["video of the right pane"] == "small-frames-1-10-right"
    assert said["measures of both panes"] == "small-frames-1-10-measures"
    assert said["3D view"] == "original-frame-5-3d-view"
    assert said["splats of this moment"] == "original-frame-5-splats"
    assert said["splats of all frames"] == "original-splats"
    assert said["page for browsers"] == "original-model"
    assert said["cameras of the clip"] == "original-cameras"
    state.scene.kind = "depth"
    assert default_name(state, "3D view") == "original-frame-5-3d-view-depth"
    assert len(set(said.values())) == len(said)


def test_nothing_that_is_there_is_replaced(run: Exporter) -> None:
    folder = run.state.export_folder
    names = [exported(run, "both panes").name for _ in range(3)]
    assert names == ["small-frame-1-both.png", "small-frame-1-both-2.png", "small-frame-1-both-3.png"]
    run.state.exports.name = "mine"
    (folder / "mine.csv.json").write_text("of another program")
    export_actions.choose_what(run.state, "measures of both panes")
    export_actions.type_name(run.state, "mine.csv")
    export_actions.start(run.state)
    run.turn(30)
    assert run.state.exports.last == folder / "mine-2.csv"
    assert (folder / "mine-2.csv.json").is_file()
    assert (folder / "mine.csv.json").read_text() == "of another program"
    assert not (folder / "mine.csv").exists()
    splats = [exported(run, "splats of all frames").name for _ in range(2)]
    assert splats == ["original-splats", "original-splats-2"]


def test_a_name_that_is_taken_while_a_video_is_made_is_not_replaced(run: Exporter) -> None:
    export_actions.choose_what(run.state, "video of both panes")
    export_actions.start(run.state)
    run.turn(3)
    assert run.state.exports.under_way is not None
    assert "export" in closing.at_stake(run.state)
    assert "discarded" in closing.what_is_kept(run.state)
    taken = run.state.export_folder / "small-frames-1-10-both.mp4"
    taken.parent.mkdir(exist_ok=True)
    taken.write_text("meanwhile")
    run.turn(40)
    assert not closing.at_stake(run.state)
    assert run.state.exports.last == taken.with_stem(f"{taken.stem}-2")
    assert taken.read_text() == "meanwhile"
    assert run.state.exports.last.with_name(f"{run.state.exports.last.name}.json").is_file()


def test_closing_tells_of_a_run_a_batch_and_an_export_that_go_on_together(
    run: Exporter, tmp_path: Path
) -> None:
    state = run.state
    export_actions.choose_what(state, "video of both panes")
    export_actions.start(state)
    run.turn(3)
    state.batches.under_way = BatchRequest((), tmp_path, Setting("vessel", VesselParams()))
    state.runs.reconstruction.status = "running"
    request = TrainRequest(clip_path=tmp_path, run_path=tmp_path / "run", config=TrainConfig())
    state.runs.reconstruction.request, state.runs.queue = request, (Waiting(None, request),)
    assert closing.at_stake(state) == (
        "run is still running, and 1 more is queued. Files and folders are still being enhanced. "
        "An export is still being written."
    )
    assert closing.what_is_kept(state) == (
        "The iterations that are done are kept: Continue resumes from there. The queue is kept for the next "
        "start. Finished files are kept; the rest are not written. "
        "What the export has written so far is discarded."
    )


def test_the_status_bar_tells_of_work_behind_closed_panels(run: Exporter, tmp_path: Path) -> None:
    state, before = run.state, menus._facts(run.state)
    export_actions.choose_what(state, "video of both panes")
    export_actions.start(state)
    state.batches.under_way = BatchRequest((), tmp_path, Setting("vessel", VesselParams()))
    state.exports.shown = state.batches.shown = False
    assert menus._facts(state) == ["Export: Preparing the first frame", "Looking for images…", *before]
    state.exports.shown = state.batches.shown = True
    assert menus._facts(state) == before


def test_free_names(tmp_path: Path) -> None:
    assert free_name(tmp_path / "none", "a", ".png") == "a.png"
    (tmp_path / "a.png").symlink_to(tmp_path / "nowhere")
    assert free_name(tmp_path, "a", ".png") == "a-2.png"
    (tmp_path / "a-2.png.json").write_text("")
    assert free_name(tmp_path, "a", ".png", beside=[".json"]) == "a-3.png"


def test_a_still_is_exported_by_another_name_than_its_own(places: Places, tmp_path: Path) -> None:
    write_image(tmp_path / "scope.png", np.full((40, 60, 3), 90, np.uint8), {})
    state, _ = opened_state(places, tmp_path / "scope.png")
    assert default_name(state, "panes and 3D view") == "scope-shown"
    assert default_name(state, "right pane") == "scope-right"


@pytest.mark.parametrize("name", ["a/b", "a\\b", "a:b", ".a", "a.", "a\tb", "x" * 200, "nul", "Com1.v2"])
def test_names_that_no_file_can_have_are_refused_with_a_reason(run: Exporter, name: str) -> None:
    export_actions.choose_what(run.state, "both panes")
    export_actions.type_name(run.state, name)
    assert export_actions.why_not_start(run.state) == why_not_name(name)
    assert why_not_name(name).startswith("A name can")
    export_actions.start(run.state)
    assert run.state.exports.under_way is None


def test_the_name_in_the_panel_says_what_will_be_written(run: Exporter) -> None:
    state = run.state
    export_actions.choose_what(state, "both panes")
    run.turn()
    assert export_actions.other_name(state) == ""
    path = exported(run, "both panes")
    run.turn()
    assert export_actions.other_name(state) == "small-frame-1-both-2.png"
    assert state.exports.named == (
        NameRequest(path.parent, path.stem, ".png", 1),
        "small-frame-1-both-2.png",
    )
    assert export_actions.added_to_name(state) == "-2"
    export_actions.type_name(state, "other.png")
    assert (state.exports.name, export_actions.other_name(state)) == ("other", "")
    export_actions.choose_what(state, "left pane")
    assert state.exports.name == ""


def test_the_name_that_is_being_written_is_that_of_the_file(run: Exporter) -> None:
    state = run.state
    path = exported(run, "both panes")
    export_actions.choose_what(state, "both panes")
    assert export_actions.name_written(state) == ""
    run.begin("both panes")
    assert export_actions.name_written(state) == path.name
    export_actions.choose_what(state, "left pane")  # Another kind, meanwhile.
    names = set()
    while state.exports.under_way is not None:
        names.add(export_actions.name_written(state))
        run.turn(1)
    assert state.exports.last is not None
    assert state.exports.last.name in names
    assert state.exports.last.name == "small-frame-1-both-2.png"


def test_the_folder_is_of_all_exports(run: Exporter, tmp_path: Path) -> None:
    run.state.window.folders = {"export": tmp_path / "elsewhere"}
    assert exported(run, "both panes").parent == tmp_path / "elsewhere"
    export_actions.save_picture(run.state)
    run.turn(4)
    assert run.state.exports.last == tmp_path / "elsewhere" / "small-frame-1.png"


# ---- formats


@pytest.mark.parametrize("image", [".png", ".tiff", ".jpg"])
def test_an_image_of_each_format_says_how_it_was_made_and_comes_again(
    run: Exporter, clip_path: Path, image: str
) -> None:
    run_path = run.state.runs.reconstruction.run_path
    assert run_path is not None
    plain = read_image(exported(run, "panes and 3D view"))
    export_actions.choose_format(run.state, "picture", image)
    export_actions.choose_quality(run.state, 90)
    path = exported(run, "panes and 3D view")
    assert path.suffix == image
    assert read_provenance(path)["kind"] == "panes"
    assert read_provenance(path).get("quality") == (90 if image == ".jpg" else None)
    assert same(path, clip_path, run_path)
    apart = np.abs(read_image(path).astype(int) - plain)
    assert apart.max() == 0 if image != ".jpg" else 0 < apart.mean() < 3
    assert not list(path.parent.glob("*.json"))


def test_a_jpeg_of_another_quality_is_found_out(run: Exporter, clip_path: Path, tmp_path: Path) -> None:
    export_actions.choose_format(run.state, "picture", ".jpg")
    path = exported(run, "left pane")
    record = export_actions.export_request(run.state, "left pane")
    assert record is not None
    export_actions.choose_quality(run.state, 60)
    export_actions.cancelled(run.state)
    coarse = exported(run, "left pane")
    assert coarse.stat().st_size < path.stat().st_size
    head, body = coarse.read_bytes(), path.read_bytes()
    end = head.index(b"\xff\xdb"), body.index(b"\xff\xdb")
    coarse.write_bytes(body[: end[1]] + head[end[0] :])  # Pixels of 60 under a record of 95.
    assert not replay(coarse, (clip_path,), tmp_path / "again.jpg").difference.is_none


def test_s_saves_png_whatever_is_chosen_for_exports(run: Exporter) -> None:
    export_actions.choose_format(run.state, "picture", ".jpg")
    export_actions.save_picture(run.state)
    (request,) = run.state.window.wishes
    assert isinstance(request, ExportRequest)
    assert request.suffix == ".png"
    assert getattr(request.record, "quality", None) is None


@pytest.mark.parametrize("words", ["export ply", "export jpeg", "export video path", "export cameras"])
def test_the_palette_finds_exports_and_opens_the_panel_on_them(run: Exporter, words: str) -> None:
    found = find(
        sections(run.state, outside()), words if "jpeg" not in words else "export image left", run.state
    )
    assert found
    found[0].command.act(run.state)
    assert run.state.exports.shown
    assert (
        run.state.exports.what
        == {
            "export ply": "splats of this moment",
            "export jpeg": "left pane",
            "export video path": "video along the path",
            "export cameras": "cameras of the clip",
        }[words]
    )


# ---- before a video is made


@pytest.mark.parametrize("encoder", [VideoEncoder("PyAV", "libx264"), VideoEncoder("OpenCV", "mp4v"), None])
def test_the_panel_draws_every_kind_and_says_who_plays_a_video(
    ui: Ui, state: AppState, encoder: VideoEncoder | None
) -> None:
    state.exports.shown, state.exports.encoder = True, encoder
    for what in OFFERS:
        export_actions.choose_what(state, what)
        for _ in range(3):
            ui.frame(lambda: draw_export(state))
    assert state.exports.shown
    if encoder is not None and encoder.program == "OpenCV":
        assert "browsers do not" in encoder.said
        assert "install ffmpeg" in encoder.way_out


def test_the_encoder_is_asked_for_once_the_panel_is_shown(run: Exporter) -> None:
    run.turn()
    assert run.state.exports.encoder is None
    floating_windows.toggle(run.state.exports)
    run.turn()
    assert run.state.exports.encoder is not None


@pytest.mark.display
def test_by_hand_from_the_palette_to_the_file(places: Places) -> None:
    driver = Driver(places, opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.key_press(chord("Ctrl+Shift+P"))
        ctx.yield_(2)
        ctx.key_chars("image right pane")
        ctx.yield_(2)
        ctx.key_press(imgui.Key.enter)
        wait(ctx, lambda: state.exports.shown and state.exports.what == "right pane", "the panel")
        ctx.yield_(2)
        ctx.set_ref(ctx.window_info("//Export/how").id_)
        ctx.combo_click("##Format/JPEG")
        ctx.item_input_value("##name", "liver before")
        ctx.item_click("###start")
        wait(ctx, lambda: state.exports.last is not None, "the image")
        ctx.set_ref("")

    driver.run(drive)
    assert state.exports.last == places.pictures / "liver before.jpg"
    assert state.exports.last is not None
    assert read_provenance(state.exports.last)["panes"][0]["shows"] == "setting"


@pytest.mark.display
def test_by_hand_splats_in_another_format(places: Places, runs: dict[str, Path]) -> None:
    driver = Driver(places, opens=runs["original"])
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.scene.model is not None, "the run")
        ctx.key_press(chord("Ctrl+Shift+P"))
        ctx.yield_(2)
        ctx.key_chars("splats this moment")
        ctx.yield_(2)
        ctx.key_press(imgui.Key.enter)
        wait(ctx, lambda: state.exports.what == "splats of this moment", "the panel")
        ctx.yield_(2)
        ctx.set_ref(ctx.window_info("//Export/how").id_)
        ctx.combo_click("##Format/SPZ (Niantic)")
        ctx.yield_(2)
        ctx.item_click("###start")
        wait(ctx, lambda: state.exports.last is not None, "the file")

    driver.run(drive)
    assert state.exports.last is not None
    assert state.exports.last.name == "original-frame-1-splats.spz"
    assert same(state.exports.last, runs["original"])


def test_what_an_export_lacks_is_said_also_while_another_runs(
    opened: AppState, ui: Ui, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    monkeypatch.setattr("app.gui.panels.export.explain", lambda text, below=True: told.append(text))
    opened.exports.shown = True
    ui.frame(lambda: draw_export(opened))
    before = [text for text in told if text]
    assert before
    told.clear()
    opened.exports.under_way = export_actions.export_request(opened, "measures of both panes")
    assert opened.exports.under_way is not None
    ui.frame(lambda: draw_export(opened))
    assert [text for text in told if text in before] == before
