"""What the window's files hold is within the ranges of its controls; what is not is as at first."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from app.enhancement.image_mask import PictureMask
from app.enhancement.settable import LONGEST_NAME, LONGEST_NOTES, MAX_ZOOM, MIN_ZOOM, MOST_FRAME
from app.errors import UserError
from app.gui.actions import arriving, path_actions, preset_actions, session_actions
from app.gui.actions.session_actions import snapshot
from app.gui.session_file import MOST_STEPS, SESSION, Session, SessionSource, mended_session
from app.gui.state.app_state import AppState
from app.gui.views.picture_view import PictureView
from app.gui.work.opening import Opened
from app.gui.work.presets import MOST_PRESETS, load_presets
from app.gui.work.settings import FILE, RECENT_LIMIT, KnownClip, Places, Settings, load_clips, load_settings
from app.runs.clip_selection import ClipPart
from app.runs.queue_file import MOST_WAITING, keep_queue, queue_file, take_over
from app.runs.train_run import TrainRequest
from enhance import EnhanceParams
from renderer.camera import Camera
from renderer.camera_files import NamedCamera
from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.view_files import LONGEST, MOST, Views, import_views, views_json
from tests.app.gui.conftest import make_model, start_live

CAMERA = Camera.from_fov(60.0, 64, 48).to_json()
FLAT = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]
LOOK = json.loads(json.dumps({"z": 0.5}))
VARIED = {"name": "p", "first": 0.0, "last": 1.0, "count": 3}


def views(**changes: Any) -> dict[str, Any]:
    return {**json.loads(views_json(Views((NamedCamera("a", Camera.from_json(CAMERA)),)))), **changes}


WRONG: list[tuple[str, Any]] = [
    *(("zoom", value) for value in (0, -1, 1e5, 1e-9, MIN_ZOOM / 2, MAX_ZOOM * 2, 10**400, "much", [])),
    *(("center", value) for value in ([1e300, 0.5], [-0.1, 0.5], [0.5], [0.5, 0.5, 0.5], 0.5, {})),
    *(("frame", value) for value in (-1, MOST_FRAME + 1, 10**30, 1.5, None, [3])),
    *(("frozen", value) for value in (-1, 10**12)),
    *((name, value) for name in ("blend", "view_time") for value in (-0.1, 1.1, 1e300)),
    *(("kept", {"params": {"d_factor": value}}) for value in (-1, 4.5, 1e308)),
    ("kept", {"params": LOOK, "since": "x" * 101}),
    *(("comparison", {"wipe": value}) for value in (-1, 1.5, 1e300)),
    ("comparison", {"mode": "at once"}),
    ("comparison", {"left": "nothing"}),
    ("scope", "all"),
    ("view_kind", "beautiful"),
    ("input", "none"),
    ("sort", "beauty"),
    ("stored", {"C": LOOK}),
    ("stored", {"A": {"z": 7}}),
    ("past", [LOOK] * (MOST_STEPS + 1)),
    ("params", {"p": [0.5] * 1000}),
    ("params", {"radii": [4] * 7}),
    ("config", {"keep": ["depth", "beauty"]}),
    ("config", {"n_gaussians": 10**9}),
    ("part", {"trim": [-5, 3]}),
    ("part", {"trim": [0, 10**15]}),
    ("part", {"mask": {"text": [0, 0, 1e30, 1]}}),
    ("part", {"mask": {"view": [0, 0, -1]}}),
    ("varied", [VARIED] * 3),
    *(("varied", [VARIED | change]) for change in ({"count": 0}, {"count": 10**6}, {"last": 1e300})),
    ("varied", [VARIED | {"name": "beauty"}]),
    ("edits", {"gaussians": -1, "deleted": "", "hidden": ""}),
    ("edits", {"gaussians": 5, "deleted": "A" * 20_000_000, "hidden": ""}),
    ("run_name", "x" * (LONGEST_NAME + 1)),
    ("notes", "x" * (LONGEST_NOTES + 1)),
    ("free", {"camera": {"fx": -1}, "down": [0, 1, 0]}),
    ("free", {"camera": CAMERA, "down": [0, 0, 0]}),
    ("free", {"camera": CAMERA, "down": [1e300, 0, 0]}),
    ("free", {"camera": CAMERA | {"camera_from_world": FLAT}, "down": [0, 1, 0]}),
    ("free", {"camera": CAMERA | {"camera_from_world": np.zeros((4, 4)).tolist()}, "down": [0, 1, 0]}),
    ("views", {"format": "?"}),
    ("views", views(views=[{"name": "a", "camera": CAMERA}] * (MOST + 1))),
    ("views", views(path={"loop": True, "keyframes": [{"seconds": 10**400, "time": 0, "camera": CAMERA}]})),
    ("views", views(path={"loop": True, "keyframes": [{"seconds": 1e300, "time": 0, "camera": CAMERA}]})),
    ("past", [[]] * 300_000),
]


def session_file(folder: Path, **changes: Any) -> Path:
    path = folder / "a.vesselsplat"
    told = SESSION.dump_python(Session(source=SessionSource("clip")), mode="json") | changes
    path.write_text(json.dumps(told))
    return path


@pytest.mark.parametrize(("name", "value"), WRONG, ids=lambda value: repr(value)[:40])
def test_a_field_out_of_its_range_is_as_at_first_and_is_said(tmp_path: Path, name: str, value: Any) -> None:
    session, said = mended_session(session_file(tmp_path, **{name: value}))
    assert session == Session(source=SessionSource("clip"))
    assert said.startswith(f"in the session, {name} cannot be read, so defaults are used")
    assert "a.vesselsplat.broken" in said
    assert len(said) < 300


def test_a_session_of_another_version_stays_where_it_is(tmp_path: Path) -> None:
    path = session_file(tmp_path, schema=2)
    with pytest.raises(UserError, match="expected a session of schema 1, got 2, which another version can"):
        mended_session(path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["source", "run"])
def test_a_path_of_millions_of_characters_is_no_path(tmp_path: Path, name: str) -> None:
    path = session_file(tmp_path, **{"source": None, name: {"path": "x" * 10_000_000}})
    with pytest.raises(UserError, match=name) as caught:
        mended_session(path)
    assert len(str(caught.value)) < 500


def test_values_at_the_ends_of_their_ranges_are_taken(tmp_path: Path) -> None:
    changes = {
        "zoom": MAX_ZOOM, "center": [0, 1], "frame": MOST_FRAME, "blend": 1, "view_time": 0,
        "notes": "x" * LONGEST_NOTES, "varied": [VARIED] * 2, "past": [LOOK] * MOST_STEPS,
        "free": {"camera": CAMERA, "down": [0, 1, 0]}, "views": views(), "sort": "dv_bv",
    }  # fmt: skip
    session, said = mended_session(session_file(tmp_path, **changes))
    assert said == ""
    assert (session.zoom, session.center, len(session.past)) == (MAX_ZOOM, (0, 1), MOST_STEPS)


def test_the_line_for_a_wrong_value_is_short() -> None:
    with pytest.raises(ValidationError):
        Session(zoom=0)
    with pytest.raises(ValidationError):
        ClipPart(trim=(-1, 3))
    with pytest.raises(ValidationError):
        PictureMask(text=(0, 0, math.inf, 1))


def test_what_the_hand_can_reach_is_within_what_a_session_takes(state: AppState, places: Places) -> None:
    """Whatever the size of picture and pane, also where the whole of it fits only beyond the zooms."""
    for picture in ((2, 2), (64, 48), (20_000, 3_000)):
        for pane in ((1.0, 1.0), (300.0, 200.0), (3840.0, 2160.0)):
            view = PictureView()
            for step in range(6):
                view = view.panned((9e3 * (-1) ** step, 4e3), picture, pane)
                if step % 2:
                    view = view.zoomed(1e3 ** (-1) ** step, (5.0, 5.0), picture, pane)
                state.picture.view = view
                snapshot(state, places.config)


def test_a_picture_that_fits_only_beyond_the_zooms_stays_whole() -> None:
    view = PictureView()
    assert view.panned((50, 50), (2, 2), (800.0, 600.0)) is view
    assert view.panned((50, 50), (64, 48), (800.0, 600.0)).zoom is not None


def test_settings_are_read_field_by_field(tmp_path: Path) -> None:
    path = tmp_path / "settings.json"
    for change in (
        {"text_percent": 10**9}, {"text_percent": 101}, {"theme": "red"}, {"recent": ["x" * 100_000]},
        {"recent": 3}, {"acknowledged": 7},
    ):  # fmt: skip
        told = {"acknowledged": True, "recent": ["/a"], "theme": "light", "text_percent": 150}
        path.write_text(json.dumps(told | change))
        expected = Settings(acknowledged=True, recent=("/a",), theme="light", text_percent=150)
        assert load_settings(path) == replace(
            expected, **{name: getattr(Settings(), name) for name in change}
        )
    path.write_text(json.dumps({"recent": [f"/{place}" for place in range(RECENT_LIMIT + 3)]}))
    assert len(load_settings(path).recent) == RECENT_LIMIT


def test_of_presets_the_readable_ones_are_there_and_stay(tmp_path: Path) -> None:
    path = tmp_path / "presets.json"
    good, long = {"z": 0.25}, "x" * (LONGEST_NAME + 1)
    damaged = json.dumps({"mine": good, "": good, long: good, "bad": {"z": 7}, "Paper": good})
    path.write_text(damaged)
    presets, trouble = load_presets(path)
    assert presets == {"mine": EnhanceParams(z=0.25), "Paper (own)": EnhanceParams(z=0.25)}
    assert "3 of 5" in trouble
    assert path.with_suffix(".damaged.json").read_text() == damaged
    assert load_presets(path) == (presets, "")
    path.write_text(json.dumps({f"preset {place}": good for place in range(MOST_PRESETS + 2)}))
    assert len(load_presets(path)[0]) == MOST_PRESETS


def test_no_more_presets_are_kept_than_are_read(state: AppState) -> None:
    state.enhancement.presets = {f"preset {place}": EnhanceParams() for place in range(MOST_PRESETS)}
    preset_actions.keep(state, "one more")
    assert state.window.banner is not None
    assert "at most" in state.window.banner.message
    assert "one more" not in state.enhancement.presets


def test_of_a_queue_only_requests_within_their_ranges_wait(tmp_path: Path) -> None:
    request = TrainRequest(clip_path=tmp_path, run_path=tmp_path, config=TrainConfig())
    keep_queue(queue_file(tmp_path), [request] * 6)
    (file,) = tmp_path.glob("queue-*.json")
    told = json.loads(file.read_text())
    told[0]["config"]["iterations"] = 10**12
    told[1]["clip_path"] = "x" * 100_000
    told[2]["part"]["trim"] = [-1, 10**20]
    told[3]["enhance_params"]["radii"] = [10**9]
    told[4]["device"] = "abacus"
    left = tmp_path / "queue-999999999.json"
    left.write_text(json.dumps(told))
    file.unlink()
    waiting, said = take_over(tmp_path)
    assert waiting == (request,)
    (broken,) = tmp_path.glob("queue-*.broken")
    assert broken.name in said
    assert json.loads(broken.read_text()) == told
    left.write_text(json.dumps([told[5]] * (MOST_WAITING + 1)))
    queue_file(tmp_path).unlink()
    assert len(take_over(tmp_path)[0]) == MOST_WAITING


def test_more_views_than_a_session_takes_are_refused_in_a_line(
    state: AppState, clip: Clip, tmp_path: Path
) -> None:
    model = make_model()
    start_live(state, model)
    camera = clip.cameras[0]
    state.scene.cameras.views = Views((NamedCamera("a", camera),) * MOST)
    path_actions.save_view(state)
    assert len(state.scene.cameras.views.named) == MOST
    assert state.window.banner is not None
    assert f"at most {MOST} views" in state.window.banner.message
    file, state.window.banner = tmp_path / "views.json", None
    file.write_bytes(views_json(Views((NamedCamera("x" * 1000, camera),))))
    path_actions.add_views(state, import_views(file), file)
    assert state.window.banner is not None
    state.scene.cameras.views = Views()
    path_actions.add_views(state, import_views(file), file)
    assert [len(one.name) for one in state.scene.cameras.views.named] == [LONGEST]
    snapshot(state, tmp_path)


def test_a_keyframe_typed_hours_away_is_a_line(state: AppState) -> None:
    start_live(state, make_model())
    path_actions.add_keyframe(state)
    path_actions.add_keyframe(state)
    before = state.scene.cameras.views
    path_actions.move_keyframe(state, 1, 1e9)
    assert state.scene.cameras.views is before
    assert state.window.banner is not None
    assert "unchanged" in state.window.banner.message


def test_a_restored_session_is_kept_in_passing_as_it_was(state: AppState, clip: Clip, places: Places) -> None:
    arriving.show_opened(state, clip.path, Opened(clip))
    kept = Session(zoom=MIN_ZOOM, center=(1.0, 0.0), varied=(), notes="x", view_time=1.0)
    session_actions.restore(state, kept)
    again = snapshot(state, places.config)
    assert (again.zoom, again.center, again.notes, again.view_time) == (MIN_ZOOM, (1.0, 0.0), "x", 1.0)


def test_of_known_clips_the_readable_ones_are_there(tmp_path: Path) -> None:
    told = {"a": {"trim": [0, 3]}, "b": {"trim": [-1, 3]}, "c": {"mask": {"view": [0, 0, 1e300]}}, "d": 3}
    told |= {"e": {"depth": "magic"}}
    (tmp_path / FILE).write_text(json.dumps(told))
    assert load_clips(tmp_path) == {"a": KnownClip(trim=(0, 3))}
    (tmp_path / FILE).write_text("[]")
    assert load_clips(tmp_path) == {}
    # As of a later version: what else was chosen for the clip stays.
    views = json.loads(views_json(Views())) | {"version": 2}
    (tmp_path / FILE).write_text(json.dumps({"a": {"trim": [0, 3], "views": views, "eyes": 3}}))
    assert load_clips(tmp_path) == {"a": KnownClip(trim=(0, 3))}
