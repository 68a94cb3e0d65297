"""What can be drawn and exported: a finished run, or a file of splats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.clip_part import WHOLE
from app.errors import UserError
from app.provenance import digest, source
from app.run_edits import edits_facts, read_edits
from app.run_folder import RunFolder, RunRecord
from app.views import SCENE_UNITS
from renderer.camera import Camera
from renderer.deformation.motion import Still
from renderer.framing import framing
from renderer.gaussians import DynamicGaussians
from renderer.splat_files import SplatFileError, is_named_as_splats, read_splats
from renderer.splats import RenderMode


@dataclass(frozen=True, eq=False)
class Scene:
    """A model with its moments and cameras."""

    name: str
    model: DynamicGaussians
    cameras: tuple[Camera, ...]
    """One a frame; of a file of splats, one that sees nearly all of them."""
    test_indices: tuple[int, ...]
    facts: dict[str, Any]
    """What an export says of it."""
    mode: RenderMode = "default"
    unit: str = SCENE_UNITS
    """Of lengths."""
    notices: tuple[str, ...] = ()
    first: int | None = None
    """The frame of the whole clip that its first one is, of a run of a part."""

    def __len__(self) -> int:
        """Frames."""
        return len(self.cameras)

    def time(self, index: int) -> float:
        """Of frame `index`, in [0, 1)."""
        return index / len(self)


def is_splat_file(path: Path) -> bool:
    """Meant as one, of a kind that can be read or not."""
    return is_named_as_splats(path)


def open_scene(path: Path, *, as_trained: bool = False) -> Scene:
    """A file of splats, or a run with what was edited by hand, unless it is wanted as trained.

    Raises:
        UserError: no finished run and no file of splats, or the edits are of another model.
    """
    if is_splat_file(path) or path.is_file():
        return splat_scene(path)
    return _run_scene(RunFolder(path), as_trained)


def splat_scene(path: Path) -> Scene:
    """Raises UserError: the file cannot be read, or is damaged."""
    try:
        file = read_splats(path)
    except SplatFileError as error:
        raise UserError(str(error)) from error
    model = DynamicGaussians(file.raw, Still())
    notices = (*file.notices, *(() if len(model) else ("no splats to draw: pictures stay black",)))
    facts = {"splats": source(path), "render_mode": file.mode, "notices": notices}
    return Scene(path.name, model, (framing(model),), (), facts, file.mode, notices=notices)


def _run_scene(folder: RunFolder, as_trained: bool) -> Scene:
    record, model = folder.record(), folder.model()
    edits = None if as_trained else read_edits(folder, len(model))
    cameras = tuple(record.camera(index) for index in range(record.clip.frames))
    name = folder.path.absolute().name
    unit = record.clip.unit
    facts = run_facts(folder, record, name) | edits_facts(edits)
    part, mode = record.clip.part, record.config.render_mode
    scene = Scene(name, model, cameras, record.test_indices, facts, mode, unit, first=part.first)
    if edits is None:
        return scene
    said = (
        f"edited by hand: {edits.count - len(edits.visible)} of {edits.count} Gaussians are left out "
        "(--as-trained keeps them)"
    )
    return replace(scene, model=edits.applied(model), notices=(said,))


def run_facts(folder: RunFolder, record: RunRecord, name: str) -> dict[str, Any]:
    """What an export says of a run; without a model's digest while it is being trained."""
    part = {} if record.clip.part == WHOLE else {"part": record.clip.part}
    return {
        "run": {"name": name, "model_sha256": digest(folder.model_path) if folder.is_finished else None},
        "clip": {"name": record.clip.name, "sha256": record.clip.sha256} | part,
        "input": record.input,
        "enhancement": record.enhancement,
        "config": record.config,
    }
