"""Every reader of the product, with the file that is damaged and what is read then."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from app.commands.described.paths import described
from app.enhancement.dicom_files import require_dicom
from app.exports.replay.recorded import recorded
from app.files.dicom.choices import DicomChoices
from app.files.image_files import read_image
from app.gui.session_file import mended_session
from app.gui.work.presets import load_presets
from app.gui.work.settings import load_settings
from app.report.section import read_report
from app.runs.progress_log import told
from app.runs.queue_file import take_over
from app.runs.run_edits import read_edits
from app.runs.run_folder import RunFolder
from app.runs.run_lock import holder
from renderer.clip import ClipError
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration_files import read_calibration
from renderer.sources import open_clip
from renderer.splat_files import read_splats
from renderer.train.checkpoint import read_checkpoint
from renderer.view_files import import_views

Read = Callable[[Path], object]


@dataclass(frozen=True)
class Reader:
    """`read` gets the folder with all files, one of which, `damaged`, is not as it was."""

    damaged: str
    read: Read


def readers(seeds: Path) -> dict[str, Reader]:
    """By name; of clips, one for each file of theirs that decides the result."""
    found = {name: Reader(name, read) for name, read in _FILES.items()}
    for layout in ("endonerf", "scared"):
        for path in _first_of_each(seeds / layout):
            found[path] = Reader(path, lambda folder, layout=layout: _clip(folder / layout))
    return found


def _first_of_each(clip: Path) -> Iterator[str]:
    """Of each folder of a clip, the first file of each suffix."""
    seen = set()
    for path in sorted(clip.rglob("*")):
        if path.is_file() and (key := (path.parent, path.suffix)) not in seen:
            seen.add(key)
            yield path.relative_to(clip.parent).as_posix()


def _clip(path: Path) -> None:
    clip = open_clip(path, ClipOptions())
    for index in range(min(len(clip), 2)):
        clip.read_frame(index)


def _model(folder: Path, method: str) -> None:
    run = RunFolder(folder / method)
    model = run.model()
    render(model.at(0.4), run.record().cameras[0])


def _checkpoint(path: Path) -> None:
    try:
        DynamicGaussians.checked(read_checkpoint(path).arrays)
    except ValueError:
        return  # Passed over for the one before it.


def _run(folder: Path) -> None:
    run = RunFolder(folder / "vesselsplat")
    record = run.record()
    tuple(record.cameras)
    run.omitted(), run.train_seconds(), told(run), described(run.path)
    read_edits(run, len(run.model()))


def _picture(path: Path) -> None:
    read_image(path)


def _clip_of_picture(path: Path) -> None:
    read_image(path)
    if path.suffix != ".npy":
        open_clip(path).read_frame(0)


def _calibrated(calibration: Path, clip: Path) -> None:
    try:
        options = ClipOptions(calibration=read_calibration(calibration))
    except ClipError:
        return
    open_clip(clip, options).read_frame(0)


def _written_dicom(path: Path) -> None:
    recorded(path)
    require_dicom((path,), DicomChoices(keep_identity=True))


_FILES: dict[str, Read] = {
    **{f"{name}/model.safetensors": lambda folder, name=name: _model(folder, name)
       for name in ("vesselsplat", "deform3dgs", "endogaussian")},
    **{f"{name}/checkpoint-0000020.safetensors":
       lambda folder, name=name: _checkpoint(folder / name / "checkpoint-0000020.safetensors")
       for name in ("vesselsplat", "deform3dgs", "endogaussian")},
    "vesselsplat/run.json": _run,
    "vesselsplat/events.jsonl": _run,
    "vesselsplat/edits.json": _run,
    "vesselsplat/.training": lambda folder: holder(folder / "vesselsplat"),
    "a.vesselsplat": lambda folder: mended_session(folder / "a.vesselsplat"),
    "settings.json": lambda folder: load_settings(folder / "settings.json"),
    "presets.json": lambda folder: load_presets(folder / "presets.json"),
    "queue-1.json": take_over,
    "views.json": lambda folder: import_views(folder / "views.json"),
    "cameras.json": lambda folder: import_views(folder / "cameras.json"),
    "transforms.json": lambda folder: import_views(folder / "transforms.json"),
    "colmap/images.txt": lambda folder: import_views(folder / "colmap" / "images.txt"),
    "colmap/cameras.txt": lambda folder: import_views(folder / "colmap" / "cameras.txt"),
    "lens.yml": lambda folder: _calibrated(folder / "lens.yml", folder / "picture.png"),
    "chain.yaml": lambda folder: _calibrated(folder / "chain.yaml", folder / "picture.png"),
    "eyes.json": lambda folder: _calibrated(folder / "eyes.json", folder / "eyes"),
    **{f"{name}.dcm": lambda folder, name=name: _clip_of_picture(folder / f"{name}.dcm")
       for name in ("still", "runs", "jpeg", "jpeg2000", "lossless", "jpegls")},
    **{f"{name}.dcm": lambda folder, name=name: _clip(folder / f"{name}.dcm") for name in ("frames", "film")},
    "enhanced.dcm": lambda folder: _written_dicom(folder / "enhanced.dcm"),
    "enhanced.png": lambda folder: recorded(folder / "enhanced.png"),
    "export.ply": lambda folder: (recorded(folder / "export.ply"), read_splats(folder / "export.ply")),
    "export.spz": lambda folder: read_splats(folder / "export.spz"),
    "export.splat": lambda folder: read_splats(folder / "export.splat"),
    "export.sog": lambda folder: read_splats(folder / "export.sog"),
    "export.ksplat": lambda folder: read_splats(folder / "export.ksplat"),
    "export.glb": lambda folder: (recorded(folder / "export.glb"), read_splats(folder / "export.glb")),
    "export-4.spz": lambda folder: read_splats(folder / "export-4.spz"),
    "export.mp4": lambda folder: _clip(folder / "export.mp4"),
    "export.mp4.json": lambda folder: (recorded(folder / "export.mp4"), described(folder)),
    "report.json": lambda folder: read_report(folder / "report.json"),
    **{f"picture.{suffix}": lambda folder, suffix=suffix: _clip_of_picture(folder / f"picture.{suffix}")
       for suffix in ("png", "jpg", "tif", "webp", "bmp", "ppm", "npy")},
}  # fmt: skip
