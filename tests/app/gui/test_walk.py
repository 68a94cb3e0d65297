"""One case from the first start to a session taken up again: a person's hands, a real job, files compared.

The window's own thread touches no file meanwhile: neither the user's nor the clip's.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import numpy as np
import pytest
from imgui_bundle.immapp import testing

from app.exports.replay.again import replay
from app.gui.actions import actions
from app.gui.commands.keys import chord
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, Settings
from app.runs.run_folder import RunFolder
from assets import phantom_path
from renderer.train.config import TrainConfig
from tests.app.gui.window_thread import files_touched
from tests.benchmarks import soak_deeds
from tests.benchmarks.person import UNPACED, Context, K, Person, quieten
from tests.benchmarks.soak_deeds import compare, reconstruct


def run_window(window: Window, drive: testing.TestFunction) -> None:
    params = window.runner_params()
    params.ini_disable = True
    testing.run(test_function=drive, runner_params=params, add_ons_params=window.add_ons())


def person_at(ctx: Context, window: Window) -> Person:
    quieten(ctx)
    return Person(ctx, window, phantom_path(), Random(0), UNPACED)


@pytest.mark.display
def test_a_case_from_first_start_to_the_session_taken_up_again(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.gui.frame.dialogs.has_desktop_dialogs", lambda: False)
    # The rasteriser draws, whether or not OpenGL is faster: what it has drawn is looked at.
    monkeypatch.setattr("app.gui.drawing.chosen_viewport.VIEWS", 10**9)
    # A short job is as real as a long one.
    monkeypatch.setattr(soak_deeds, "STEPS", 10)
    monkeypatch.setattr(soak_deeds, "TRIMMED", 6)
    for folder in vars(places).values():
        Path(folder).mkdir(parents=True, exist_ok=True)
    window = Window(AppState(places, Settings()))
    state, deleted = window.state, 0

    def drive(ctx: Context) -> None:
        nonlocal deleted
        person = person_at(ctx, window)
        with files_touched((*vars(places).values(), phantom_path())) as touched:
            person.click("//Before you begin/I understand")
            person.click("//Images/**/###phantom")
            person.wait(lambda: state.source.opening is None and person.settled(), "the phantom")
            ctx.item_input_value("//Enhancement/**/##d_factor", 0.4)
            person.wait(lambda: state.enhancement.params.d_factor == 1.5 and person.settled(), "the setting")
            compare(person)
            state.runs.reconstruction.config = TrainConfig(n_gaussians=500)
            reconstruct(person)
            assert person.run is not None
            scrub(person)
            deleted = edit(person)
            export(person)
            person.press(chord("Ctrl+S"))
            person.wait(lambda: state.window.browsing is not None, "the dialog")
            ctx.yield_(3)
            person.press(K.enter)
            person.wait(
                lambda: state.session.path is not None and state.session.path.is_file(), "the session"
            )
            assert not touched, "\n".join(dict.fromkeys(touched))

    run_window(window, drive)
    (run,) = (RunFolder(path) for path in places.runs.iterdir())
    assert run.record().config.iterations == 10
    saved = [path for path in places.pictures.iterdir() if path.suffix in (".png", ".mp4")]
    assert {path.suffix for path in saved} == {".png", ".mp4"}
    for path in saved:
        assert replay(path, (), path.with_stem("again")).sentence == "identical", path.name
    assert state.session.path is not None

    again = Window(AppState(places, Settings(acknowledged=True)))
    actions.open_path(again.state, state.session.path)

    def look(ctx: Context) -> None:
        person = person_at(ctx, again)
        person.wait(
            lambda: again.state.source.opening is None and again.state.scene.view is not None, "the session"
        )

    run_window(again, look)
    assert again.state.enhancement.params == state.enhancement.params
    assert again.state.timeline.frame_index == state.timeline.frame_index
    assert len(again.state.editing.edits.deleted) == deleted
    assert again.state.scene.model is not None
    assert len(again.state.scene.model.model) == len(run.model()) - deleted


def scrub(person: Person) -> None:
    """Time moves both the picture and the reconstruction."""
    state = person.state
    person.open(person.run or Path())
    person.wait(lambda: state.scene.view is not None, "the 3D view")
    seen = []
    for end in (0.05, 0.95):
        person.drag("//**/strip", (0.5, 0.5), (end, 0.5))
        person.wait(lambda: person.settled() and not state.is_busy, "the frame")
        person.wait(
            lambda: state.scene.view is not None and state.scene.view.request == state.view_request,
            "its view",
        )
        assert state.picture.pictures is not None
        assert state.scene.view is not None
        seen.append((state.picture.pictures.original, state.scene.view.image, state.timeline.frame_index))
    assert seen[0][2] != seen[1][2]
    assert not np.array_equal(seen[0][0], seen[1][0])
    assert not np.array_equal(seen[0][1], seen[1][1])


def edit(person: Person) -> int:
    """How many Gaussians of the left half have been deleted, for good."""
    state = person.state
    idle = lambda: state.editing.wish is None and not state.editing.stroke  # noqa: E731
    person.press(chord("Ctrl+E"))
    person.wait(lambda: state.editing.active and idle(), "edit mode")
    person.drag("//3D view/view", (0.02, 0.02), (0.5, 0.98))
    person.wait(idle, "the selection")
    chosen = len(state.editing.edits.selected)
    person.press(K.delete)
    person.wait(lambda: len(state.editing.edits.deleted) == chosen > 0, "the deletion")
    person.click("//Edit/###edit Save")
    person.wait(lambda: not state.editing.is_unsaved, "the saved edits")
    person.press(chord("Ctrl+E"))
    return chosen


def export(person: Person) -> None:
    """Both panes as a picture, and as a video."""
    exports = person.state.exports
    person.press(chord("Ctrl+Shift+E"))
    for what in ("both panes", "video of both panes"):
        person.click(f"//Export/**/###{what}")
        person.click("//Export/**/###start")
        person.wait(lambda: exports.under_way is None and not person.state.is_busy, what)
    person.press(chord("Ctrl+Shift+E"))
