"""After the one-time preparation nothing that a person does compiles another kernel."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import get_args

import numpy as np
import pytest

import enhance
import renderer
from app.enhancement.clip_statistics import OfClip
from app.enhancement.frame_enhancer import PictureMaker, PictureRequest
from app.enhancement.image_mask import PictureMask
from app.enhancement.methods import EnhancementSettings, MethodEnhancer
from app.enhancement.settable import Pixels, Scope
from app.evaluation.evaluate import open_evaluation
from app.gui.work.baking import BakeRequest, bake, can_bake
from app.gui.work.measuring import Measurer
from app.gui.work.presets import presets_with
from app.gui.work.selecting import Around, PickRequest, Selector, SelectRequest, pick
from app.gui.work.thumbnails import ThumbnailsRequest, make_thumbnails
from app.kernels.progress import tasks
from app.kernels.stamp import loaded_kernels
from app.kernels.steps import use
from app.runs.clip_selection import ClipPart
from app.runs.train_run import PRESETS, TrainRequest, run_training
from app.scenes.drawer import draw_view
from app.scenes.scene import Scene, open_scene
from app.scenes.view_kinds import ViewKind
from app.scenes.view_request import FrameRequest, ViewRequest
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.clip import Clip
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import Method, TrainConfig

NEVER_CALLED = {
    "renderer.deformation.row_products._block",
    "renderer.rasterize.picture.adjoint_of",
}
"""By Python, or by the app: part of another kernel; of drawing by torch."""
SETTINGS: tuple[EnhancementSettings, ...] = (
    *PRESETS.values(),
    EnhanceParams(strength=0.5, d_factor=2.0, omit_below=0.0),
    EnhanceParams(z=0.4, p=(0.2, 0.9), radii=(4, 30), eps=0.01, subsample=1, omit_below=1.0),
    VesselParams(strength=2.0),
)
WAYS: tuple[tuple[Scope, Pixels, OfClip], ...] = (
    ("image", "automatic", None),
    ("image", "all", None),
    ("image", "tissue", None),
    ("automatic", "automatic", "later"),
    ("automatic", "all", None),
    ("clip", "tissue", None),
)
"""What statistics are of."""


def signatures() -> set[str]:
    """Of each kernel the types that it has been compiled for."""
    found: set[str] = set()
    for name, kernel in loaded_kernels().items():
        found |= {f"{name}{types}" for types in kernel.overloads}
    return found


def load_all() -> None:
    """Every module that may hold kernels of the app."""
    for package in (enhance, renderer):
        for found in walk_packages(package.__path__, f"{package.__name__}."):
            if not {"torch_train", "measuring", "cuda", "differentiable"} & set(found.name.split(".")):
                import_module(found.name)


def _enhance_everything() -> None:
    # Statistics of a clip are of each of its frames: kernels do not know how many.
    clip, maker = ClipPart(trim=(2, 5)).of(open_clip(phantom_path())), PictureMaker()
    for params in SETTINGS:
        for scope, pixels, of_clip in WAYS:
            *_, made = maker.make(PictureRequest(clip, 1, params, scope, pixels, of_clip=of_clip))
        for mask in (PictureMask(), PictureMask(text=(0, 0, 40, 20))):
            *_, made = maker.make(PictureRequest(clip, 0, params, mask=mask))
        list(Measurer().measure(made))
    list(make_thumbnails(ThumbnailsRequest(made, tuple(presets_with({}).items()))))
    grey = np.asarray(clip.read_image(0)[..., 0])
    for image in (grey, grey.astype(np.uint16), (clip.read_image(0) / 255.0).astype(np.float32)):
        enhancer = MethodEnhancer()
        for params in PRESETS.values():
            enhancer.show(image)
            enhancer.enhance(params)


def _train_everything(clip: Path, folder: Path) -> None:
    # Frames are enhanced before a method sees them, for each in the same way.
    for method, given in (
        *((one, "original") for one in get_args(Method)),
        (get_args(Method)[0], "enhanced"),
    ):
        path = folder / f"{method}-{given}"
        config = TrainConfig(method=method, iterations=20, n_gaussians=600, checkpoint_every=10)
        request = TrainRequest(
            clip_path=clip,
            run_path=path,
            config=config,
            input=given,  # type: ignore[arg-type]
        )
        list(run_training(request))
    moving = TrainConfig(iterations=20, n_gaussians=600, sh_degree=3, render_mode="mip", hold_out=True)
    request = TrainRequest(clip_path=clip, run_path=folder / "mip", config=moving)
    list(run_training(request))


def _look_at(scene: Scene, clip: Clip) -> None:
    view = ViewRequest.of_frame(scene, 2)
    for kind in get_args(ViewKind):
        list(draw_view(view.of_kind(kind, FrameRequest(clip, 2))))
    list(pick(PickRequest(view, (80, 64), "measure")))
    list(Selector().select(SelectRequest(scene, view, Around((80, 64), "sphere", 5.0))))
    if not can_bake(scene):
        return
    request = BakeRequest(scene)
    while (baked := next(bake(request))).keyframes is None:
        request = BakeRequest(scene, baked.baker, baked.request.part + 1)


def check(clip: Path, folder: Path) -> None:
    """In a process of its own, where nothing else has been compiled. The clip is another one than that of the
    preparation."""
    for task in tasks():
        use(task)
    prepared = signatures()
    load_all()
    idle = {name for name, kernel in loaded_kernels().items() if not kernel.overloads}
    # Those that are part of another kernel are compiled with it, unless that one comes from disk.
    assert sorted(name for name in idle - NEVER_CALLED if ".measuring." not in name) == []
    _enhance_everything()
    _train_everything(clip, folder)
    for path in sorted(folder.iterdir()):
        _look_at(open_scene(path), open_clip(clip))
        list(open_evaluation(path).frames())
    assert sorted(signatures() - prepared) == []


@pytest.mark.slow
def test_nothing_is_compiled_after_the_preparation(tmp_path: Path, made_once: Callable[..., Path]) -> None:
    params = PhantomParams(n_frames=10, width=160, height=128, seed=1)
    clip = made_once("middling", lambda folder: write_phantom(folder / "clip", params, "endonerf")) / "clip"
    paths = f"Path({str(clip)!r}), Path({str(tmp_path)!r})"
    code = f"from pathlib import Path; from {__name__} import check; check({paths})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-3000:]
