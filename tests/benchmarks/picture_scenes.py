"""What pictures of the window are taken of: each scene yields a name whenever it is ready for one."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from imgui_bundle import ImVec2

from app.gui.actions import (
    actions,
    clip_actions,
    closing,
    edit_actions,
    export_actions,
    floating_windows,
    second_actions,
    tuning_actions,
)
from app.gui.commands.keys import chord
from app.gui.frame import dockings
from app.gui.session_file import Choice
from app.runs.job import Failed
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest
from app.scenes.supersampling import FACTORS
from assets import phantom_path
from renderer.gaussians import DynamicGaussians
from renderer.splat_files.inria_ply import ply_bytes
from renderer.train.events import Evaluated, Finished, Omission, Progress, Started, Warned
from tests.app.gui.conftest import FakeJob
from tests.benchmarks.person import K, Person

STEPS = 3000
OMITTED = (
    Omission("spherical harmonics above degree 0", "the camera does not move.", "45 numbers per Gaussian"),
    Omission("the mask of tools", "no tool is in any frame.", "a pass over each frame"),
)
REPORT = Path(__file__).parents[2] / "assets" / "pictures" / "report.json"
Scene = Callable[[Person, "Model"], Iterator[str]]


@dataclass(frozen=True, eq=False)
class Model:
    """A finished reconstruction of the phantom."""

    run: Path
    gaussians: DynamicGaussians

    @classmethod
    def of_run(cls, run: Path) -> Model:
        return cls(run, RunFolder(run).model())


def start(person: Person, model: Model) -> Iterator[str]:
    person.ctx.yield_(3)
    yield "notice"
    person.click("//Before you begin/I understand")
    yield "welcome"
    actions.fail(person.state, "expected a clip, got a folder of 3 text files: nothing")
    yield "banner"
    person.state.window.banner = None
    person.state.session.recoverable = person.places.config / "autosave-1.vesselsplat"
    yield "recovery"
    person.state.session.recoverable = None
    person.ctx.popup_close_all()
    person.press(chord("Ctrl+I"))
    yield "open file"
    person.press(K.escape)
    person.press(chord("Ctrl+Shift+P"))
    person.ctx.key_chars("open")
    yield "palette"
    person.press(K.escape)
    person.press(chord("?"))
    yield "help"
    person.press(chord("?"))
    person.press(K.f1)
    person.wait(lambda: person.state.guide.pages is not None, "the guide")
    yield "guide"
    person.press(K.escape)
    floating_windows.toggle(person.state.about)
    person.wait(lambda: person.state.about.facts is not None, "what the program is")
    yield "about"
    floating_windows.toggle(person.state.about)


def overview(person: Person, model: Model) -> Iterator[str]:
    """As the README shows it: assets/pictures/app.png."""
    person.open(model.run)
    person.choose("//Enhancement", "##preset", "Vessels")
    person.wait(lambda: person.settled() and person.state.scene.view is not None, "the frames and the model")
    person.ctx.window_focus("//Runs")
    person.wait(lambda: person.state.runs.found is not None, "the runs")
    person.ctx.mouse_move_to_pos(ImVec2(5, 715))
    person.ctx.sleep_no_skip(1.0, 0.1)
    yield "overview"
    person.press(chord("Ctrl+Z"))
    person.ctx.window_focus("//Reconstruction")


def pictures(person: Person, model: Model) -> Iterator[str]:
    person.open(phantom_path())
    person.ctx.window_focus("//Images")
    person.wait(lambda: person.state.timeline.strip is not None, "the strip")
    person.ctx.mouse_move("//Images/left")
    yield "side by side"
    for key, name in ((K.w, "wipe"), (K.t, "flip"), (K.d, "difference")):
        person.press(key)
        person.wait(person.settled, name)
        yield name
    person.press(K.v)
    person.press(K.z)
    person.press(K.f)
    person.press(K._1)
    yield "zebra frozen"
    person.press(K.z)
    person.press(K.f)
    person.press(K._0)
    person.press(K.e)
    person.wait(person.settled, "plain white light")
    yield "white light"
    person.press(K.e)
    person.choose("//Images", "##right", "Method: CLAHE")
    person.wait(person.settled, "the other method")
    yield "other method"
    person.state.comparing.chosen = person.state.comparing.chosen.renewed()


def enhancement(person: Person, model: Model) -> Iterator[str]:
    person.wait(lambda: person.state.picture.measured is not None, "the measures")
    for tab in ("Curves", "Measures", "###windows"):
        person.click(f"//Enhancement/details/{tab}")
        person.ctx.yield_(10)
        yield f"enhancement {tab.strip('#').lower()}"
    person.choose("//Enhancement", "##preset", "Vessels")
    person.wait(person.settled, "the preset")
    yield "enhancement vessel"
    person.press(chord("Ctrl+Z"))
    person.wait(person.settled, "undo")


def clip(person: Person, model: Model) -> Iterator[str]:
    person.state.timeline.frame_index = 4
    clip_actions.trim_here(person.state, start=True)
    person.state.timeline.frame_index = 18
    clip_actions.trim_here(person.state, start=False)
    mask = person.state.source.part.mask.drawn("text", (10, 10), (80, 40))
    clip_actions.set_mask(person.state, mask)
    clip_actions.finish_mask(person.state)
    person.state.picture.overlay = True
    person.click("//**/###mask")
    person.wait(lambda: person.state.picture.left_out is not None, "the tint")
    yield "clip mask"
    person.press(K.escape)
    person.state.picture.overlay = False
    clip_actions.clear_mask(person.state)
    clip_actions.untrim(person.state)


def tuning(person: Person, model: Model) -> Iterator[str]:
    person.press(chord("Ctrl+T"))
    person.ctx.yield_(3)
    yield "tuning empty"
    tuning_actions.choose_axis(person.state, 0, Choice("d_factor", 0.0, 4.0, 3))
    tuning_actions.choose_axis(person.state, 1, Choice("p", 0.2, 0.8, 4))
    person.click("//Tuning/###try")
    person.wait(lambda: not person.state.tuning.running, "the grid")
    yield "tuning"
    assert person.state.tuning.grid is not None
    tuning_actions.look_at(person.state, person.state.tuning.grid.settings[5])
    person.wait(lambda: person.state.tuning.request is None, "the cell")
    yield "tuning one"
    tuning_actions.look_at(person.state, None)
    person.press(chord("Ctrl+T"))


def reconstruction(person: Person, model: Model) -> Iterator[str]:
    state = person.state
    person.ctx.window_focus("//Reconstruction")
    yield "reconstruction idle"
    person.click("//Reconstruction/**/What will be left out")
    person.wait(lambda: state.runs.omissions is not None, "what is left out")
    person.ctx.mouse_move("//Reconstruction/###start")
    yield "reconstruction left out"
    person.click("//Reconstruction/**/###keep harmonics")
    person.wait(
        lambda: bool(state.runs.omissions and state.runs.omissions.kept), "what is left out with that kept"
    )
    person.ctx.sleep_no_skip(1.0, 0.1)
    yield "reconstruction kept"
    person.press(chord("Ctrl+Z"))
    person.click("//Reconstruction/**/What will be left out")
    person.choose("//Reconstruction/choices", "##Frames", "Both in turn")
    person.click("//Reconstruction/###start")
    job = state.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    yield "reconstruction starting"
    job.inbox = [Started(0, STEPS, 7000, OMITTED), *progress(1400), Evaluated(1000, 30.2)]
    job.model = model.gaussians
    person.ctx.yield_(3)
    person.ctx.window_focus("//3D view")
    person.wait(lambda: state.scene.view is not None, "the preview")
    yield "reconstruction running"
    person.ctx.window_focus("//Runs")
    yield "runs waiting"
    person.ctx.window_focus("//Reconstruction")
    state.window.closing = "asked"
    yield "question closing"
    closing.answer_closing(state, close=False)
    person.ctx.popup_close_all()
    person.ctx.window_focus("//Reconstruction")
    state.runs.queue = ()
    assert isinstance(job.request, TrainRequest)
    shutil.copytree(model.run, job.request.run_path, ignore=shutil.ignore_patterns("model.*"))
    job.inbox = [
        Warned("the depth of 3 frames is empty"),
        Failed("the training process was killed by SIGKILL"),
    ]
    person.wait(lambda: state.runs.reconstruction.status == "failed", "the failure")
    yield "reconstruction failed"
    state.window.banner = None
    person.click("//Reconstruction/**/View model")
    person.ctx.window_focus("//3D view")
    person.wait(lambda: state.scene.view is not None, "the model as it was last seen")
    yield "reconstruction unfinished"
    person.choose("//Reconstruction/choices", "##Frames", "Original")
    person.click("//Reconstruction/###start")
    job = state.runs.reconstruction.job
    assert isinstance(job, FakeJob)
    job.inbox = [Started(0, STEPS, 7000, OMITTED), *progress(STEPS), Evaluated(STEPS, 33.61)]
    job.inbox += [Finished(STEPS, 39.2, model.gaussians)]
    person.wait(lambda: state.runs.reconstruction.status == "finished", "the end")
    yield "reconstruction finished"


def progress(last: int) -> list[object]:
    """What a training says until that step."""
    steps = np.arange(50, last + 1, 50)
    return [
        Progress(
            int(i), STEPS, 0.3 / (1 + i / 90), 34 - 14 / (1 + i / 250), i / 76, (STEPS - i) / 76, 7000 + i
        )
        for i in steps
    ]


def view(person: Person, model: Model) -> Iterator[str]:
    state = person.state
    person.open(model.run)
    person.ctx.window_focus("//3D view")
    person.wait(lambda: state.scene.view is not None, "the view")
    person.drag("//3D view/view", (0.5, 0.5), (0.6, 0.45))
    person.ctx.window_focus("//Runs")
    person.wait(lambda: state.runs.found is not None, "the runs")
    yield "view free"
    person.press(K.home)
    person.press(K.c)
    yield "view frame"
    person.press(K.c)
    person.press(K.n)
    person.press(K.m)
    for x in (0.44, 0.55):
        person.drag("//3D view/view", (x, 0.5), (x, 0.5))
        person.ctx.yield_(20)
    yield "view depth measured"
    person.press(K.m)
    state.scene.kind = "color"
    person.press(K.g)
    yield "view flying"
    person.press(K.g)
    person.press(K.home)
    second_actions.open_second(state, model.run)
    person.wait(lambda: state.scene.second.view is not None, "the second view")
    yield "view two"
    second_actions.close_second(state)


def cameras(person: Person, model: Model) -> Iterator[str]:
    person.ctx.window_focus("//Cameras")
    yield "cameras empty"
    person.press(K.b)
    person.press(K.i)
    for x in (0.6, 0.4):
        person.drag("//3D view/view", (0.5, 0.5), (x, 0.55))
        person.press(K.i)
    person.press(K.b)
    yield "cameras"
    person.ctx.window_focus("//Reconstruction")
    person.press(K.home)


def editing(person: Person, model: Model) -> Iterator[str]:
    state = person.state
    person.press(chord("Ctrl+E"))
    person.wait(lambda: state.editing.active and state.editing.wish is None, "edit mode")
    yield "edit"
    person.press(chord("Shift+R"))
    person.drag("//3D view/view", (0.3, 0.2), (0.55, 0.9))
    person.wait(lambda: state.editing.wish is None and not state.editing.stroke, "the selection")
    yield "edit selected"
    person.press(K.delete)
    actions.open_path(state, phantom_path())
    yield "question edits"
    person.ctx.item_click("//Unsaved edits/Stay")
    while state.editing.history.past:
        person.press(chord("Ctrl+Z"))
    edit_actions.toggle(state)


def windows(person: Person, model: Model) -> Iterator[str]:
    state = person.state
    person.press(chord("Ctrl+Shift+E"))
    yield "export"
    state.exports.supersampling = FACTORS[-1]
    person.click("//Export/**/###video through time")
    person.click("//Export/**/###start")
    person.wait(lambda: state.exports.under_way is not None and state.exports.done > 0, "a frame")
    yield "export under way"
    export_actions.cancelled(person.state)
    person.wait(lambda: not state.exports.is_busy, "the end of the export")
    state.exports.supersampling = FACTORS[0]
    yield "toast"
    person.press(chord("Ctrl+Shift+E"))
    for panel in ("Log", "Notes"):
        dockings.toggle(panel)
        state.session.notes = "Left ureter crosses at frame 14; compare d 2 against d 1."
        person.ctx.yield_(3)
        yield panel.lower()
        dockings.toggle(panel)
    dockings.toggle("Report")
    person.ctx.yield_(3)
    yield "report empty"
    person.open(REPORT)
    yield "report"
    part = "Enhancement: error against run time"
    for item in (part, f"Every parameter##{part}0"):
        person.ctx.item_open(f"//Report/{item}")
    person.ctx.scroll_to_bottom("//Report")
    yield "report table"
    dockings.toggle("Report")
    person.press(chord("Ctrl+Shift+B"))
    yield "files and folders"
    person.press(chord("Ctrl+Shift+B"))
    for menu in ("File", "Image", "Compare", "Clip", "Reconstruct", "Camera", "View", "Help"):
        person.ctx.set_ref("//##MainMenuBar")
        person.ctx.menu_click(menu)
        person.ctx.set_ref("")
        yield f"menu {menu.lower()}"
        person.ctx.popup_close_all()


def tooltip(person: Person, model: Model) -> Iterator[str]:
    person.ctx.window_focus("//Enhancement")
    person.ctx.mouse_move("//Enhancement/##Method")
    person.ctx.sleep_no_skip(1.0, 0.1)
    yield "tooltip"
    person.ctx.mouse_move_to_pos(ImVec2(5, 5))


def splats(person: Person, model: Model) -> Iterator[str]:
    file = person.places.pictures / "splats.ply"
    file.write_bytes(ply_bytes(model.gaussians.raw, "default", []))
    person.open(file)
    person.wait(lambda: person.state.scene.view is not None, "the splats")
    person.ctx.yield_(4)
    yield "splats alone"


SCENES: tuple[Scene, ...] = (
    start, overview, pictures, enhancement, clip, tuning, reconstruction, view, cameras, editing, windows,
    tooltip, splats,
)  # fmt: skip
