"""What a run, a splat file, a session, a report or an exported file holds."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from app.commands.described.cameras import of_cameras
from app.commands.described.fact import Fact, made, next_steps, notices
from app.console.flags import problem
from app.errors import UserError
from app.exports.replay.recorded import recorded
from app.gui.session_file import SESSION, SessionSource
from app.live.picture import FRAME, RECORDING
from app.report.section import holds_report, read_report
from app.runs.exposure_record import ExposureRecord
from app.runs.run_folder import ClipRecord, RunFolder
from app.runs.run_lock import holder
from app.runs.wall_clock import STEPS, WALL, in_all
from renderer.json_files import read_json
from renderer.listing import count
from renderer.poses.told_apart import TISSUE
from renderer.readers.clip_files import files_in
from renderer.readers.lenses.calibration import Calibration
from renderer.regular_files import read_regular
from renderer.splat_files import SplatFileError, read_splats, whole
from renderer.splat_files.splat_records import RECORD

READ_WHOLE = 64 << 20
"""Bytes: a larger file of splats is told by its header."""
FOR_OTHERS = (".glb", ".usdc", ".4dgs", ".obj", ".npz", ".csv", ".html")
READ_FOR_FACTS = (".glb", ".html", ".obj", ".ply", ".usdc")
"""Of which all is read for what they say of themselves; a file beside others tells it."""
Facts = tuple[Fact, ...]


def of_run(path: Path) -> Facts:
    """Raises UserError: run.json is damaged."""
    run = RunFolder(path)
    record, events = run.record(), run.events()
    clip, config = record.clip, record.config
    there = Path(clip.path).exists()
    told = {event["event"]: event for event in events}
    state = "finished" if run.is_finished else "being trained" if holder(path) else "not finished"
    steps_of = told.get("Finished", told.get("Progress", {})).get("seconds")
    quality = told.get("Evaluated", {}).get("psnr")
    facts = [
        Fact("what", f"run, {state}", {"kind": "run", "state": state}),
        Fact(
            "clip",
            clip.path if there else f"{clip.path}, which no longer exists",
            {"path": clip.path, "there": there},
        ),
        Fact(
            "frames",
            f"{clip.frames}, {len(record.test_indices)} of them held out",
            {"count": clip.frames, "held_out": len(record.test_indices)},
        ),
        Fact(
            "method",
            f"{config.method}, {record.input} frames, on {record.device}",
            {"method": config.method, "input": record.input, "device": record.device},
        ),
        *_so_far(told, config.iterations),
        *_time(steps_of, run.wall_seconds()),
        Fact("unit", clip.unit),
        *_lens(clip.options.calibration),
        *_poses(clip),
        *_exposure(record.exposure),
        made(record.created, record.version),
    ]
    if quality is not None:
        facts.append(Fact("quality", f"{quality:.2f} dB on held-out frames", {"psnr": quality}))
    if run.edits_path.exists():
        facts.append(Fact("edits", "edited in the app", True))
    facts += notices([event["message"] for event in events if event["event"] == "Warned"])
    return (*facts, next_steps(path, *_steps(state, clip.path if there else None)))


def _so_far(told: Mapping[str, Mapping[str, Any]], asked: int) -> Facts:
    """Steps that are done, and the model that they gave, by the last event of each kind."""
    done = told.get("Finished", told.get("Progress", {})).get("iteration", 0)
    wanted = told.get("Started", {}).get("iterations", asked)
    counted = (told.get(name, {}).get("n_gaussians") for name in ("Finished", "Progress", "Started"))
    size = next(filter(None, counted), None)
    return (
        Fact("iterations", f"{done} of {wanted}", {"done": done, "wanted": wanted}),
        Fact("model", count(size, "Gaussian") if size else "none yet", {"gaussians": size}),
    )


def _steps(state: str, clip: str | None) -> list[tuple[str, ...]]:
    """What to do with a run; `clip`: where its clip is, None where that is gone."""
    if state == "finished":
        evaluate = [("evaluate", "PATH")] if clip else []
        return [("render", "PATH", "--out", "OUT"), *evaluate, ("export", "PATH", "--ply", "OUT")]
    if state == "being trained":
        return [("gui", "PATH")]
    return [("train", clip, "--run", "PATH", "--resume")] if clip else []


def _lens(calibration: Calibration | None) -> list[Fact]:
    """Of a run whose images are undistorted."""
    if calibration is None:
        return []
    lens, found = calibration.lens, calibration.found
    values = {"model": lens.model, "distortion": lens.distortion}
    if found is None:
        return [Fact("lens", "calibrated: images are undistorted", values | {"found": False})]
    k1 = float(lens.coefficients[0])
    text = (
        f"found from the motion of the camera: images are undistorted by k1 = {k1:.3f}, standard deviation "
        f"{found.deviation:.3f}"
    )
    return [Fact("lens", text, values | {"found": True, "k1": k1, "deviation": found.deviation})]


def _poses(clip: ClipRecord) -> list[Fact]:
    """How well the poses fit that were estimated for the run; nothing where the clip had poses."""
    if (poses := clip.poses) is None:
        return []
    residuals = [each for each in poses.residuals if each is not None]
    typical, worst = float(np.median(residuals)), max(residuals)
    text = (
        f"estimated, {typical:.1f} px from where points are expected (median), {worst:.1f} in the worst frame"
    )
    if poses.tissue is not None:
        text += f"; {TISSUE[poses.tissue]}"
    focal = [camera.fx for camera in clip.seen_from]
    if (zoom := max(focal) / min(focal)) > 1:
        text += f"; the lens zooms, by up to {100 * (zoom - 1):.0f} %"
    facts = {
        "estimated": True,
        "residual_px": typical,
        "worst_px": worst,
        "lost": len(poses.lost),
        "zoom": zoom,
    }
    return [Fact("poses", text, facts | {"tissue": poses.tissue})]


def _exposure(found: ExposureRecord | None) -> list[Fact]:
    """How the run corrects brightness; nothing of a run by a version that did not look for that."""
    if found is None:
        return []
    if not found.gains:
        return [Fact("exposure", f"steady: {found.said}", {"jitter": found.jitter, "gains": False})]
    low, high = min(found.gains), max(found.gains)
    text = f"{found.said}: gains from {low:.2f} to {high:.2f}, views and exports show steady light"
    facts = {"jitter": found.jitter, "gains": True, "least": low, "most": high}
    return [Fact("exposure", text, facts)]


def _time(steps: object, wall: float | None) -> Facts:
    """Seconds of training; nothing before the first step."""
    if not isinstance(steps, int | float):
        return ()
    definitions = {"train_seconds": STEPS, "wall_seconds": WALL}
    facts = {"train_seconds": steps, "wall_seconds": wall, "definitions": definitions}
    return (Fact("time", in_all(wall, steps), facts),)


def of_splats(path: Path, facts: dict[str, Any] | None = None) -> Facts:
    """`facts`: what it says of itself. Raises UserError: it cannot be read."""
    place = whole(path)
    size = sum(file.stat().st_size for file in (files_in(place) if place.is_dir() else (path,)))
    form = ".sog" if place.is_dir() else path.suffix.lower()
    said: tuple[str, ...] = ()
    if size <= READ_WHOLE or place.is_dir():
        try:
            file = read_splats(path)
        except SplatFileError as error:
            raise UserError(str(error)) from error
        number, said = len(file.raw), file.notices
        told = f"{count(number, 'Gaussian')}, harmonics of {file.raw.harmonics.shape[1]} functions"
    else:
        number = _announced(path)
        told = f"{number} Gaussians, as the file states"
    return (
        Fact("what", f"splat file: {form}", {"kind": "splats", "format": form}),
        Fact("model", told, {"gaussians": number}),
        Fact("size", f"{size / 1e6:.1f} MB", size),
        Fact("unit", "scene units"),
        *notices(said),
        *(() if facts is None else _told(facts)),
        next_steps(path, ("render", "PATH", "--out", "OUT", "--time", "0"), ("gui", "PATH")),
    )


def of_series(path: Path, files: Sequence[Path]) -> Facts:
    """A folder of splat files, one a moment. Raises UserError: the first cannot be read."""
    (model,) = (fact for fact in of_splats(files[0]) if fact.name == "model")
    size = sum(file.stat().st_size for file in files)
    return (
        Fact("what", "splat files, one per moment", {"kind": "splat series"}),
        Fact("files", f"{len(files)}, {files[0].name} to {files[-1].name}", {"count": len(files)}),
        Fact("model", f"{model.text}, at the first moment", model.value),
        Fact("size", f"{size / 1e6:.1f} MB", size),
        Fact("unit", "scene units"),
        next_steps(path, ("render", "PATH", "--out", "OUT"), ("gui", "PATH")),
    )


def _announced(path: Path) -> int:
    if path.suffix.lower() == ".splat":
        return path.stat().st_size // RECORD.itemsize
    with path.open("rb") as file:
        found = re.search(rb"element vertex (\d+)", file.read(1 << 16))
    if found is None:
        raise UserError(f"expected a splat file of less than {READ_WHOLE >> 20} MB, or a PLY: {path}")
    return int(found[1])


def of_session(path: Path) -> Facts:
    """Raises UserError: it is damaged; unlike opening, this leaves the file alone."""
    try:
        session = SESSION.validate_json(read_regular(path))
    except ValidationError as error:
        raise UserError(f"the session is damaged ({problem(error)}): {path}") from error
    places = (("source", session.source), ("run", session.run), ("second view", session.second))
    notes = (Fact("notes", tuple(session.notes.splitlines()), session.notes),) if session.notes else ()
    return (
        Fact("what", "session", {"kind": "session"}),
        *(_place(name, source, path) for name, source in places if source is not None),
        Fact("frame", str(session.frame), session.frame),
        made(session.saved, session.version),
        *notes,
        next_steps(path, ("gui", "PATH")),
    )


def _place(name: str, source: SessionSource, path: Path) -> Fact:
    found = source.found(path)
    text = str(found) if found else f"{source.path}, which no longer exists"
    return Fact(name, text, {"path": source.path, "there": found is not None})


def of_report(path: Path) -> Facts:
    """Raises UserError: it is damaged."""
    report = read_report(path)
    return (
        Fact("what", "report", {"kind": "report"}),
        Fact("clip", report.clip),
        Fact("made", report.utc),
        Fact("parts", ", ".join(report.sections), list(report.sections)),
        next_steps(path, ("gui", "PATH")),
    )


def of_json(path: Path) -> Facts:
    """A report, what lies beside an exported file, or cameras. Raises UserError: none of these."""
    if holds_report(path):
        return of_report(path)
    export = path.with_suffix("")
    try:
        facts = read_json(path)
    except ValueError:
        facts = None
    if not isinstance(facts, dict) or facts.get("app") != "VesselSplat":
        return of_cameras(path)
    there = export.is_file()
    if not there and "kind" not in facts:
        return _of_command(facts)
    text = f"provenance of {export.name}" + ("" if there else ", which no longer exists")
    steps = (next_steps(export, ("replay", "PATH")),) if there and can_replay(facts) else ()
    return (Fact("what", text, {"kind": "provenance"}), *_told(facts), *steps)


def _of_command(facts: dict[str, Any]) -> Facts:
    """What a command has written of all that it made, beside no file of that name."""
    cells = facts.get("cells")
    if isinstance(cells, list):
        what = Fact("what", f"tuning, {count(len(cells), 'setting')}", {"kind": "tuning"})
    else:
        what = Fact("what", "facts that a command of VesselSplat told", {"kind": "facts"})
    return (what, *(fact for fact in _told(facts) if fact.name != "export"))


def of_export(facts: dict[str, Any]) -> Facts:
    """What a file that this program wrote says of itself."""
    return (Fact("what", "exported by VesselSplat", {"kind": "export"}), *_told(facts))


def can_replay(facts: dict[str, Any]) -> bool:
    """Not what was recorded as it came."""
    return facts.get("kind") not in (FRAME, RECORDING)


def export_facts(path: Path) -> dict[str, Any] | None:
    """What the file says of itself, if it is an export; None too of one that is too large to be read for
    that."""
    if path.suffix.lower() in READ_FOR_FACTS and path.stat().st_size > READ_WHOLE:
        return None
    try:
        return recorded(path)
    except UserError:
        return None


def is_for_others(path: Path, facts: dict[str, Any]) -> bool:
    """Whether other programs open the export, and this one does not."""
    suffix, kind = path.suffix.lower(), facts.get("kind")
    if suffix == ".glb":
        return kind != "splats"
    return suffix in FOR_OTHERS or kind == "surface mesh"


def _told(facts: dict[str, Any]) -> Facts:
    """Where an export comes from, of its provenance."""
    first = next(iter(facts.get("pictures") or [facts]))
    found = [Fact("export", str(facts.get("kind", "of an unknown kind")))]
    for name in ("source", "clip", "run", "splats"):
        origin = first.get(name)
        if isinstance(origin, dict) and "name" in origin:
            sha = origin.get("sha256") or origin.get("model_sha256")
            found.append(Fact(name, f"{origin['name']}" + (f", SHA-256 {sha[:16]}…" if sha else ""), origin))
    for name in ("method", "frame", "time", "view", "renderer", "input"):
        is_of_one = name == "frame" and first is not facts
        if (value := first.get(name)) is not None and not is_of_one:
            # Of panes, a frame is its number with its name.
            told = (
                f"{value['index']}: {value['label']}"
                if isinstance(value, dict) and "label" in value
                else value
            )
            found.append(Fact(name, str(told), value))
    params = first.get("params")
    if isinstance(params, dict):
        text = ", ".join(f"{name} {value}" for name, value in params.items() if value is not None)
        found.append(Fact("parameters", text, params))
    return (*found, made(facts.get("utc"), facts.get("version")))
