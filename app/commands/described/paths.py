"""Finds what a path is, and has that described."""

from __future__ import annotations

from pathlib import Path

from app.commands.described.cameras import COLMAP, of_cameras
from app.commands.described.clips import of_clip, of_values, of_video
from app.commands.described.fact import Fact, next_steps
from app.commands.described.files import (
    can_replay,
    export_facts,
    is_for_others,
    of_export,
    of_json,
    of_run,
    of_series,
    of_session,
    of_splats,
)
from app.errors import UserError
from app.files.image_files import TIFF
from app.gui.session_file import SUFFIX
from app.report.section import REPORT, holds_report
from app.runs.run_folder import RunFolder
from app.sweeps.folder import SWEEP, is_sweep
from renderer.clip import ClipError
from renderer.layouts import layout_of
from renderer.listing import count, listed
from renderer.readers.image_files.file_kinds import is_frame, is_visible, moves, natural_key
from renderer.readers.image_folders.picture_kinds import frame_folder
from renderer.regular_files import require_file_or_folder
from renderer.splat_files import is_named_as_splats
from renderer.splat_series import series_files


def described(path: Path) -> tuple[Fact, ...]:
    """What it is read as, what is missing, and what to do next.

    Reads headers, a handful of frames and the packets of a video that is not large, and writes nothing.

    Raises:
        UserError, ClipError, OSError: nothing there, or nothing that can be read.
    """
    if not path.exists():
        raise UserError(
            f"expected a clip, image, video, run, splat file or session, got no such path: {path}"
        )
    require_file_or_folder(path)
    if path.is_dir():
        return Fact("path", str(path)), *_folder(path)
    return Fact("path", str(path)), *_file(path)


def _file(path: Path) -> tuple[Fact, ...]:
    if path.suffix == SUFFIX:
        return of_session(path)
    if path.suffix == ".safetensors":
        return of_run(path.parent)
    facts = export_facts(path)
    if facts is not None and is_for_others(path, facts):
        return *of_export(facts), next_steps(path, ("replay", "PATH"))
    if is_named_as_splats(path):
        return of_splats(path, facts)
    if path.name == SWEEP and is_sweep(path.parent):
        return _sweep(path.parent)
    if path.suffix == ".json":
        return of_json(path)
    if path.suffix == ".html" and holds_report(path.with_suffix(".json")):
        return of_json(path.with_suffix(".json"))
    if path.suffix in (".toml", ".jsonl", ".parquet") or (path.suffix == ".csv" and facts is None):
        return _of_sweep(path)
    own = _own(path)
    if facts is None:
        return own
    # An export is told as such first, then what it is like any picture or video.
    kept = [fact for fact in own if fact.name in ("frames", "frame rate", "size")]
    output = "OUT.mp4" if any(fact.name == "frame rate" for fact in own) else "OUT.png"
    if not can_replay(facts):
        # What was recorded live is a clip like any other.
        return *of_export(facts), *(fact for fact in own if fact.name != "what")
    return *of_export(facts), *kept, next_steps(path, ("replay", "PATH"), ("enhance", "PATH", output))


def _own(path: Path) -> tuple[Fact, ...]:
    """Of an image or a video. Raises ClipError: neither."""
    try:
        return of_clip(path) if layout_of(path).name == "image" else of_video(path)
    except ClipError:
        stored = of_values(path) if path.suffix.lower() in (*TIFF, ".npy") else None
        if stored is None:
            raise
        return stored


def _folder(path: Path) -> tuple[Fact, ...]:
    if RunFolder(path).is_run:
        return of_run(path)
    if is_sweep(path):
        return _sweep(path)
    if is_named_as_splats(path):
        return of_splats(path)
    if files := series_files(path):
        return of_series(path, files)
    if holds_report(path / REPORT):
        return of_json(path / REPORT)
    known = layout_of(path).name != "images"
    pictures = any(is_frame(entry) for entry in frame_folder(path).iterdir())
    if known or pictures:
        return of_clip(path)
    return of_cameras(path) if (path / COLMAP).is_file() else _other(path)


def _of_sweep(path: Path) -> tuple[Fact, ...]:
    from app.commands.described.sweeps import of_spec, of_table

    return of_spec(path) if path.suffix == ".toml" else of_table(path)


def _sweep(folder: Path) -> tuple[Fact, ...]:
    from app.commands.described.sweeps import of_sweep

    return of_sweep(folder)


def _other(path: Path) -> tuple[Fact, ...]:
    """A folder that is no clip itself: of folders, or of videos. Raises UserError: of neither."""
    inside = sorted((entry for entry in path.iterdir() if is_visible(entry)), key=natural_key)
    folders = [entry for entry in inside if entry.is_dir()]
    videos = [entry for entry in inside if entry.is_file() and moves(entry)]
    if not folders and not videos:
        files = f", with {listed([entry.name for entry in inside])}" if inside else ", which is empty"
        raise UserError(
            f"expected images, videos or folders of them, got a folder without any{files}: {path}"
        )
    kinds = {"folder": folders, "video": videos}
    found = {one: [entry.name for entry in each] for one, each in kinds.items() if each}
    parts = " and ".join(count(len(names), one) for one, names in found.items())
    return (
        Fact("what", f"folder of {parts}, not itself a clip", {"kind": "folder"}),
        *(Fact(f"{one}s", listed(names), names) for one, names in found.items()),
        next_steps(path, ("info", str((videos or folders)[0])), ("enhance", "PATH", "OUT", "--recursive")),
    )
