"""What a person does with the window, at random and again and again: a deed ends where any may begin."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import ImVec2

from app.gui.actions import (
    actions,
    clip_actions,
    depth_actions,
    export_actions,
    job_actions,
    second_actions,
    session_actions,
    tuning_actions,
)
from app.gui.commands.keys import chord
from app.gui.frame import dockings
from app.gui.session_file import Choice
from assets import phantom_path
from enhance import EnhanceParams
from tests.benchmarks.person import K, Person

STEPS = 50
TRIMMED = 20
"""Frames that are reconstructed: to estimate depth of 250 takes more than a minute."""
Deed = Callable[[Person], None]


def slide(person: Person) -> None:
    for _ in range(4):
        name = person.rng.choice(["d_factor"] * 2 + ["z", "p"])
        person.choose("//Enhancement", "##preset", "Paper, colour 0.50")
        if name != "d_factor":
            person.click(f"//Enhancement/**/Auto##{name}")
        for _ in range(5):
            person.ctx.item_input_value(f"//Enhancement/**/##{name}", round(person.rng.uniform(0.1, 0.9), 2))
            person.pace()
    person.wait(person.settled, "the new setting")
    person.press(chord("Ctrl+Z"))
    person.press(chord("Ctrl+Y"))
    for tab in ("Curves", "Measures", "###windows"):
        person.click(f"//Enhancement/details/{tab}")
    person.press(K.r)


def compare(person: Person) -> None:
    sides = person.rng.sample(
        ["Method: CLAHE", "Stored settings A", "Enhanced (current settings)", "Original"], 2
    )
    person.press(chord("Shift+A"))
    for side, entry in zip(("left", "right"), sides, strict=True):
        person.choose("//Images", f"##{side}", entry)
    for key in person.rng.sample([K.v, K.w, K.t, K.d, K.z, K.x], 6):
        person.press(key)
        person.wait(person.settled, "a way of comparing")
    person.press(K.v)
    person.press(K.w)
    person.ctx.item_drag_with_delta("//Images/line", ImVec2(person.rng.uniform(-120, 120), 0))
    person.pace()
    person.press(K.v)
    person.wheel("//Images/left", 3)
    person.drag("//Images/left", (0.5, 0.5), (0.3, 0.6))
    person.press(K._1)
    person.press(K._0)
    if person.state.comparing.chosen.zebra:
        person.press(K.z)
    person.state.comparing.chosen = person.state.comparing.chosen.renewed()


def play(person: Person) -> None:
    for _ in range(3):
        person.drag("//**/strip", (person.rng.random(), 0.5), (person.rng.random(), 0.5))
        person.wait(person.settled, "the frame")
    person.press(K.p)
    end = time.monotonic() + 4
    while time.monotonic() < end:
        person.ctx.yield_()
        time.sleep(0.04)
    person.press(K.p)
    for key in (K.comma, K.period, K.f, K.f):
        person.press(key)
    person.press(chord("Shift+M"))
    person.press(chord("Shift+M"))


def mask_tools(person: Person) -> None:
    masking = person.state.masking
    person.press(chord("Ctrl+M"))
    for tool in ("Paint", "Grow", "Erase"):
        person.wait(lambda: masking.shown is not None and not masking.is_busy, "the mask")
        person.click(f"//Masks/{tool}###mask {tool.lower()}")
        starts, ends = ((person.rng.random(), person.rng.random()) for _ in range(2))
        person.drag("//Images/left", starts, ends)
    person.wait(lambda: not masking.is_busy, "the masks to be kept")
    person.press(chord("Ctrl+Z"))
    person.wait(lambda: not masking.is_busy, "the mask to be kept")
    person.click("//Masks/Drop###mask Drop")
    person.wait(lambda: not masking.is_busy, "the mask to be dropped")
    person.press(K.escape)


def look_around(person: Person) -> None:
    if not with_run(person):
        return
    view, rng = "//3D view/view", person.rng
    for _ in range(6):
        person.drag(view, (rng.random(), rng.random()), (rng.random(), rng.random()), rng.choice([0, 1]))
    for steps in (2, -1):
        person.wheel(view, steps)
    for _ in range(7):
        person.press(K.n)
    person.press(K.home)
    person.press(K.c)
    person.press(K.right_bracket)
    person.press(K.c)
    person.press(K.m)
    person.drag(view, (0.5, 0.5), (0.5, 0.5))
    person.press(K.m)
    person.press(K.home)
    person.drag("//**/strip", (0.1, 0.5), (0.9, 0.5))


def fly_a_path(person: Person) -> None:
    if not with_run(person):
        return
    for key in (K.b, K.i):
        person.press(key)
    person.drag("//3D view/view", (0.4, 0.5), (0.6, 0.6))
    person.press(K.i)
    person.press(K.l)
    end = time.monotonic() + 3
    while time.monotonic() < end:
        person.ctx.yield_()
        time.sleep(0.04)
    if person.state.scene.cameras.playing:
        person.press(K.l)
    person.press(K.g)
    person.press(K.g)
    person.press(K.home)


def look_at_two(person: Person) -> None:
    if not with_run(person):
        return
    assert person.run is not None
    second_actions.open_second(person.state, person.run)
    person.wait(lambda: person.state.scene.second.view is not None, "the second view")
    for _ in range(3):
        person.drag("//3D view/view", (person.rng.random(), 0.5), (person.rng.random(), 0.6))
    second_actions.close_second(person.state)
    person.pace()


def edit(person: Person) -> None:
    if not with_run(person):
        return
    state = person.state
    idle = lambda: state.editing.wish is None and not state.editing.stroke  # noqa: E731
    person.press(chord("Ctrl+E"))
    person.wait(lambda: state.editing.active and idle(), "edit mode")
    for keys in ("Shift+R", "Shift+L"):
        person.press(chord(keys))
        person.drag("//3D view/view", (0.1, 0.1), (person.rng.uniform(0.3, 0.9), 0.9))
        person.wait(idle, "the selection")
    person.press(K.delete)
    person.press(chord("Ctrl+A"))
    person.press(K.h)
    while state.editing.history.past:
        person.press(chord("Ctrl+Z"))
        person.wait(idle, "an edit undone")
    person.press(chord("Ctrl+E"))


def tune(person: Person) -> None:
    if not isinstance(person.state.enhancement.params, EnhanceParams):
        return  # What is varied here is of the paper's method.
    person.press(chord("Ctrl+T"))
    tuning_actions.choose_axis(person.state, 0, Choice("d_factor", 0.0, person.rng.uniform(1, 4), 3))
    tuning_actions.choose_axis(person.state, 1, Choice("p", 0.2, person.rng.uniform(0.5, 1), 3))
    person.pace()
    person.click("//Tuning/###try")
    person.wait(lambda: person.state.tuning.grid is not None and not person.state.tuning.running, "the grid")
    person.choose("//Tuning", "##order", "Vessel contrast")
    grid = person.state.tuning.grid
    assert grid is not None
    tuning_actions.look_at(person.state, person.rng.choice(grid.settings))
    person.wait(lambda: person.state.tuning.request is None, "the cell")
    person.click("//Tuning/###back")
    person.choose("//Tuning", "##order", "As varied")
    person.press(chord("Ctrl+T"))


def export(person: Person) -> None:
    person.press(K.s)
    person.press(chord("Ctrl+Shift+E"))
    for what in person.rng.sample(["left pane", "right pane", "both panes"], 2):
        person.click(f"//Export/**/###{what}")
        person.click("//Export/**/###start")
        person.wait(lambda: person.state.exports.under_way is None, "the export")
    person.click("//Export/**/###video of both panes")
    person.click("//Export/**/###start")
    exports = person.state.exports
    person.wait(lambda: exports.under_way is None or exports.done > 3, "a few frames")
    export_actions.cancelled(person.state)
    person.wait(lambda: person.state.exports.under_way is None, "the cancelled export")
    person.press(chord("Ctrl+Shift+E"))


def reconstruct(person: Person) -> None:
    """Fifty steps, to the end or until it is cancelled."""
    state, finish = person.state, person.run is None or person.rng.random() < 0.4
    guess_depth(person)
    trim(person)
    state.runs.reconstruction.config = replace(state.runs.reconstruction.config, iterations=STEPS)
    job_actions.start_reconstruction(state)
    person.wait(lambda: not state.runs.starts, "the start")
    begun = state.runs.reconstruction
    person.wait(lambda: state.runs.reconstruction is not begun or begun.progress is not None
                or not begun.is_alive, "the first step")  # fmt: skip
    if finish:
        person.wait(lambda: not state.runs.reconstruction.is_alive, "the reconstruction")
        if state.runs.reconstruction.status == "finished":
            person.run = state.runs.reconstruction.run_path
    else:
        person.click("//Reconstruction/###pause")
        person.wait(
            lambda: not state.runs.reconstruction.is_alive or state.runs.reconstruction.status == "paused",
            "a pause",
        )
        job_actions.cancel(state)
        person.wait(lambda: not state.runs.reconstruction.is_alive, "the cancelled job")
    clip_actions.untrim(state)
    person.pace()


def trim(person: Person) -> None:
    state, clip = person.state, person.state.source.clip
    assert clip is not None
    first = person.rng.randrange(max(len(clip) - TRIMMED, 1))
    for frame, start in ((first, True), (first + TRIMMED - 1, False)):
        actions.seek(state, frame)
        clip_actions.trim_here(state, start=start)


def guess_depth(person: Person) -> None:
    """Of a clip that has none, as a video."""
    clip = person.state.source.clip
    if clip is not None and not clip.has_depth:
        depth_actions.choose_source(person.state, "brightness")
        person.wait(
            lambda: (now := person.state.source.clip) is not None and now.has_depth, "a guess of depth"
        )


def go_elsewhere(person: Person) -> None:
    person.open(phantom_path())
    person.press(K.e)
    person.press(K.e)


def keep_session(person: Person) -> None:
    state = person.state
    state.session.notes = f"after {person.acts} acts"
    if state.session.path is None:
        session_actions.save_to(state, state.places.pictures / "soak.vesselsplat")
    else:
        person.press(chord("Ctrl+S"))
    person.wait(lambda: state.session.path is not None and state.session.path.is_file(), "the session")
    assert state.session.path is not None
    person.open(state.session.path)


def look_at_panels(person: Person) -> None:
    for panel in ("Log", "Notes"):
        for _ in range(2):
            dockings.toggle(panel)
            person.pace()
    for _ in range(2):
        person.press(chord("?"))
    person.press(K.f1)
    person.press(K.page_down)
    person.press(K.escape)
    person.press(chord("Ctrl+Shift+P"))
    person.ctx.key_chars("theme")
    person.pace()
    person.press(K.escape)
    for theme in ("light", "dark"):
        actions.choose_theme(person.state, theme)
        person.pace()
    for steps in (1, 0):
        actions.resize_text(person.state, steps)
        person.pace()


def with_run(person: Person) -> bool:
    """Opened, with its view on screen."""
    if person.run is None or not person.run.is_dir():
        person.run = None
        reconstruct(person)
    if person.run is None:
        return False
    person.run.touch()  # The newest are kept.
    person.open(person.run)
    person.wait(lambda: person.state.scene.view is not None, "the 3D view")
    person.ctx.yield_(3)
    return True


DEEDS: dict[Deed, float] = {
    slide: 5, compare: 4, play: 3, look_around: 3, fly_a_path: 2, look_at_two: 1, edit: 2, tune: 2,
    export: 2, reconstruct: 1, go_elsewhere: 2, keep_session: 1, look_at_panels: 1, mask_tools: 1,
}  # fmt: skip
"""Each with its weight."""
