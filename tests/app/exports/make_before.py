"""How the files in `before/` were made: every kind of export, with the small clip, runs and picture it is of.

`python -m tests.app.exports.make_before FOLDER` makes such a folder by the version that stands, for a next
set beside the first; what is there stays as it is, since it stands for files that people have.
"""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.__main__ import main
from app.exports.exporting import export
from app.gui.actions import actions, comparing, edit_actions, second_actions, window_actions
from app.gui.state.exports import What
from app.gui.work.saving_edits import SaveRequest, write_splats
from app.gui.work.settings import Places
from app.runs.run_edits import save_edits
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from renderer.camera_path import CameraPath, Keyframe
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.phantom import PhantomParams, write_phantom
from renderer.train.config import TrainConfig
from tests.app.gui.exporting import Exporter

CONFIG = TrainConfig(iterations=60, n_gaussians=300, initial_spacing=0.3)
SIZE = (48, 36)


def command(*arguments: object) -> None:
    assert main([str(argument) for argument in arguments]) == 0, arguments


def make(folder: Path) -> None:
    """Into an empty folder."""
    clip, run, mip = folder / "clip", folder / "run", folder / "mip"
    write_phantom(clip, PhantomParams(n_frames=6, width=64, height=48, seed=1), "endonerf")
    shutil.rmtree(clip / "vessel_masks")
    list(run_training(TrainRequest(clip_path=clip, run_path=run, config=CONFIG, input="enhanced")))
    list(run_training(TrainRequest(clip_path=clip, run_path=mip, config=replace(CONFIG, render_mode="mip"))))
    _by_commands(folder, clip, run, mip)
    _by_window(folder, run, mip)
    pictures = (folder / name for name in ("panes.png", "panes-wipe.png", "render-color.png", "enhanced.png"))
    command("summary", folder / "summary.html", *pictures, "--title", "A case", "--note", "two panes")
    for path in (run, mip):
        _without_the_place(path)
    for name in ("config", "pictures"):
        shutil.rmtree(folder / name, ignore_errors=True)


def _by_commands(folder: Path, clip: Path, run: Path, mip: Path) -> None:
    command("enhance", clip, folder / "pooled", "--statistics", "clip", "--pixels", "tissue", "--z", "0.3")
    _keep(folder / "pooled", {"frame-000002.color.png": "enhanced.png"})
    command("export", run, "--html", folder / "model.html")
    command("export", run, "--mesh", folder / "surface.glb", "--vertices", "300")
    command("export", run, "--usd", folder / "splats.usdc", "--4dgs", folder / "splats.4dgs")
    for form in ("ply", "obj"):
        flags = ("--mesh-format", form, "--vertices", "300", "--frames", "2")
        command("export", run, "--mesh", folder / form, *flags)
        _keep(folder / form, {f"frame-000002.{form}": f"surface.{form}"})
    command("export", run, "--npz", folder / "arrays.npz", "--frames", "1", "4")
    command("export", run, "--tracks", folder / "tracks.csv", "--points", "30,20", "12,40")
    command("render", run, "--out", folder / "depth16", "--frames", "3", "--depth", "--depth-format", "png16")
    _keep(folder / "depth16", {"frame-000003-depth16.png": "depth16.png"})
    image = folder / "photo.png"
    image.write_bytes(next(iter(sorted((clip / "images").iterdir()))).read_bytes())
    command("enhance", image, folder / "vessel.tiff", "--method", "vessel")
    command("enhance", image, folder / "clahe.npy", "--method", "clahe")
    command("enhance", clip, folder / "enhanced.mp4", "--statistics", "clip")
    command("tune", image, "--vary", "d_factor=0,2", "--out", folder / "tuned")
    _keep(folder / "tuned", {"sheet.png": "tuning-sheet.png", "setting-001.png": "tuned.png"})
    for name, path, flags in (
        ("color", run, ("--depth", "--supersampling", "2")),
        ("difference", run, ("--view", "difference")),
        ("motion", mip, ("--view", "motion", "--size", *SIZE)),
        ("clear", mip, ("--transparent",)),
        ("opengl", mip, ("--with", "gl")),
    ):
        command("render", path, "--out", folder / name, "--frames", "3", *flags)
        _keep(
            folder / name,
            {
                "frame-000003.png": f"render-{name}.png",
                "frame-000003-depth.png": "depth.png",
                "frame-000003-depth.npy": "depth.npy",
                "frame-000003-depth.npy.json": "depth.npy.json",
            },
        )
    command("export", run, "--video", folder / "render.mp4", "--view", "difference")
    command("export", mip, "--ply", folder / "ply", "--frames", "2", "--sh-degree", "1")
    _keep(folder / "ply", {"frame-000002.ply": "splats.ply"})
    command("export", mip, "--compressed-ply", folder / "packed", "--frames", "2")
    _keep(folder / "packed", {"frame-000002.compressed.ply": "splats.compressed.ply"})
    command("export", mip, "--glb", folder / "glb", "--frames", "2")
    _keep(folder / "glb", {"frame-000002.glb": "splats.glb"})
    command("render", folder / "splats.ply", "--out", folder / "of-splats", "--size", *SIZE)
    _keep(folder / "of-splats", {"frame-000000.png": "render-splats.png"})


def _by_window(folder: Path, run: Path, mip: Path) -> None:
    places = Places(folder / "config", folder / "runs", folder / "pictures")
    none = Edits.none(len(RunFolder(run).model()))
    gone = np.arange(none.count) % 3 == 0
    save_edits(RunFolder(run), none.selecting(Mask.of(gone), "replace").deleting())
    window = Exporter(places, run)
    state = window.state
    actions.seek(state, 3)
    window.turn(6)

    def keep(what: What, name: str) -> None:
        path = window.made(what)
        for made in path.parent.glob(f"{path.name}*"):
            made.rename(folder / made.name.replace(path.name, name))

    comparing.choose_source(state, "left", "original")
    keep("both panes", "panes.png")
    for mode in ("wipe", "difference"):
        comparing.choose_mode(state, mode)
        window.turn(6)
        keep("panes as shown", f"panes-{mode}.png")
    keep("video of the panes", "panes.mp4")
    state.exports.sizing = replace(state.exports.sizing, width=100)
    comparing.choose_source(state, "right", "clahe")
    comparing.choose_source(state, "left", "render")
    comparing.choose_mode(state, "side by side")
    window.turn(6)
    keep("panes and 3D view", "panes-and-view.png")
    keep("measures of both panes", "measures.csv")
    second_actions.open_second(state, mip)
    window.turn(6)
    state.scene.kind = "depth"
    window.turn(6)
    keep("3D view", "views.png")
    assert state.scene.model is not None
    near, far = (state.scene.model.camera_at(time) for time in (0.0, 0.5))
    path = CameraPath((Keyframe(0.0, 0.0, near), Keyframe(0.2, 0.9, far)))
    state.scene.cameras.views = replace(state.scene.cameras.views, path=path)
    keep("video through time", "views.mp4")
    second_actions.close_second(state)
    keep("video along the path", "path.mp4")
    image = np.full((30, 40, 3), 90, np.uint8)
    (step,) = export(window_actions.window_request(state, image))
    assert step.path is not None
    step.path.rename(folder / "window.png")
    splats = Exporter(places, folder / "splats.ply")
    edit_actions.toggle(splats.state)
    splats.turn(6)
    edit_actions.draw_on(splats.state, (0, 0))
    edit_actions.draw_on(splats.state, (24, 36))
    edit_actions.end_stroke(splats.state, "replace")
    splats.turn(6)
    edit_actions.delete(splats.state)
    assert not splats.state.editing.edits.is_empty
    editing = splats.state.editing
    assert editing.base is not None
    source = folder / "splats.ply"
    write_splats(SaveRequest(editing.base, source, editing.edits, editing.saved, splats.state.time))


def _keep(folder: Path, names: dict[str, str]) -> None:
    """Some files of a folder, beside it; the others go."""
    for path in folder.iterdir():
        if path.name in names:
            path.rename(folder.parent / names[path.name])
        else:
            path.unlink()
    folder.rmdir()


def _without_the_place(run: Path) -> None:
    """What a run needs to be drawn; its clip is found from the folder of the exports."""
    for path in run.iterdir():
        if path.name not in ("run.json", "model.safetensors"):
            path.unlink()
    record = json.loads((run / "run.json").read_text())
    record["clip"]["path"] = "clip"
    (run / "run.json").write_text(json.dumps(record, indent=1))


if __name__ == "__main__":
    make(Path(sys.argv[1]))
