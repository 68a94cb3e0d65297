"""Small valid files of every kind that the product reads, made by the product itself."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from pydicom.uid import JPEGLosslessSV1, JPEGLSLossless

from app.__main__ import main
from app.enhancement.image_mask import PictureMask
from app.gui.session_file import Choice, KeptSettings, Session, SessionSource, UnsavedEdits, write_session
from app.gui.views.comparison import Comparison
from app.gui.work.presets import save_presets
from app.gui.work.settings import Settings, settings_content
from app.runs.clip_selection import ClipPart
from app.runs.queue_file import keep_queue
from app.runs.run_edits import packed, save_edits
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from app.scenes.free_camera import FreeView
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.camera import Camera
from renderer.camera_files import NamedCamera, splatting_json
from renderer.camera_path import CameraPath, Keyframe
from renderer.editing.edits import Edits
from renderer.editing.mask import Mask
from renderer.phantom import PhantomParams, write_phantom
from renderer.train.config import TrainConfig
from renderer.view_files import Views, views_json
from tests.renderer.readers.dicom_files import (
    VIDEO,
    compressed,
    labelled,
    lossless,
    picture,
    saved,
    stills,
    video,
    video_file,
    with_pixels,
)
from tests.renderer.splat_files.files import gaussians, spz_streams
from tests.renderer.splat_files.ksplat_files import ksplat
from tests.renderer.splat_files.sog_files import bundled, sog

CONFIG = TrainConfig(iterations=20, n_gaussians=80, checkpoint_every=10)


def make_seeds(folder: Path) -> None:
    """Clips, a run of each method, exports, and files of the window, under `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    params = PhantomParams(n_frames=6, width=64, height=48, seed=1)
    for layout in ("endonerf", "scared"):
        write_phantom(folder / layout, params, layout)
    for method in ("vesselsplat", "deform3dgs", "endogaussian"):
        run = folder / method
        config = replace(CONFIG, method=method, keep=("deformation",))
        list(run_training(TrainRequest(clip_path=folder / "endonerf", run_path=run, config=config)))
    run = RunFolder(folder / "vesselsplat")
    _window_files(folder, run)
    _cameras(folder, run)
    _pictures(folder)
    _calibrations(folder)
    _dicom(folder)
    _exports(folder, run)


def _window_files(folder: Path, run: RunFolder) -> None:
    model = run.model()
    edits = Edits.none(len(model))
    save_edits(run, replace(edits, deleted=Mask.of(np.arange(len(model)) < 9)))
    write_session(folder / "a.vesselsplat", session_of(run, folder))
    (folder / "settings.json").write_bytes(settings_content(Settings(recent=("a", "b"))))
    save_presets(folder / "presets.json", {"mine": EnhanceParams()})
    keep_queue(folder / "queue-1.json", [TrainRequest(clip_path=folder, run_path=folder, config=CONFIG)])


def session_of(run: RunFolder, folder: Path) -> Session:
    """With every field set."""
    model, camera = run.model(), run.record().cameras[0]
    mask = Mask.of(np.arange(len(model)) % 7 == 0)
    path = CameraPath((Keyframe(0.0, 0.0, camera), Keyframe(2.0, 0.5, camera), Keyframe(3.0, 1.0, camera)))
    views = Views((NamedCamera("a", camera), NamedCamera("b", camera)), path, loop=True, unit="mm")
    return Session(
        source=SessionSource("endonerf"),
        run=SessionSource.of(run.path, folder),
        part=ClipPart(trim=(1, 4), mask=PictureMask(text=(3, 4, 20, 9), view=(32, 24, 30))),
        edits=UnsavedEdits(len(model), *packed(replace(Edits.none(len(model)), deleted=mask))),
        frame=3,
        frozen=2,
        params=EnhanceParams(z=0.3, p=(0.2, 0.5, 1.0)),
        past=(EnhanceParams(), VesselParams(), EnhanceParams(z=0.3, p=(0.2, 0.5, 1.0))),
        scope="clip",
        pixels="tissue",
        stored={"A": EnhanceParams(z=0.7), "B": VesselParams(strength=3.0)},
        comparison=Comparison("wipe", "A", "clahe", 0.3, zebra=True),
        zoom=2.5,
        center=(0.4, 0.6),
        linked=False,
        view_time=0.4,
        free=FreeView(camera, (0.0, 1.0, 0.0)),
        views=views,
        view_kind="depth",
        blend=0.3,
        config=replace(CONFIG, keep=("deformation",)),
        input="enhanced",
        kept=KeptSettings(EnhanceParams(d_factor=0.7), "2026-01-02 03:04"),
        run_name="second try",
        varied=(Choice("d_factor", 0.0, 2.0, 3), Choice("p", 0.2, 0.8, 2)),
        tuning_shown=True,
        sort="dv_bv",
        notes="Zwölf Uhr: ein Gefäß\nunclear",
    )


def _cameras(folder: Path, run: RunFolder) -> None:
    camera = run.record().cameras[0]
    path = CameraPath((Keyframe(0.0, 0.0, camera), Keyframe(2.0, 1.0, camera)))
    (folder / "views.json").write_bytes(views_json(Views((NamedCamera("a", camera),), path)))
    (folder / "cameras.json").write_bytes(splatting_json([NamedCamera("a", camera)]))
    (folder / "transforms.json").write_text(
        '{"w": 64, "h": 48, "fl_x": 60, "frames": [{"file_path": "a", "transform_matrix": '
        "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}"
    )
    colmap = folder / "colmap"
    colmap.mkdir(exist_ok=True)
    (colmap / "cameras.txt").write_text("1 PINHOLE 64 48 60 60 32 24\n")
    (colmap / "images.txt").write_text("1 1 0 0 0 0 0 0 1 a.png\n\n")
    assert isinstance(camera, Camera)


def _pictures(folder: Path) -> None:
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.integers(0, 255, (48, 64, 3), dtype=np.uint8), (0, 0), 2)
    for suffix in ("png", "jpg", "tif", "webp", "bmp", "ppm"):
        Image.fromarray(image).save(folder / f"picture.{suffix}")
    np.save(folder / "picture.npy", image)
    main(["enhance", str(folder / "picture.png"), str(folder / "enhanced.png")])


def _calibrations(folder: Path) -> None:
    """Of picture.png, and of a pair of 64x48."""
    matrix, bent, shift = (
        [[60.0, 0, 31], [0, 61.0, 25], [0, 0, 1]],
        [-0.3, 0.1, 0.001, 0.0, 0.0],
        [-4.0, 0, 0],
    )
    store = cv2.FileStorage(str(folder / "lens.yml"), cv2.FILE_STORAGE_WRITE)
    store.write("image_width", 64)
    store.write("image_height", 48)
    store.write("camera_matrix", np.array(matrix))
    store.write("distortion_coefficients", np.array(bent))
    store.release()
    eye = {"M1": matrix, "D1": bent, "M2": matrix, "D2": bent, "R": np.eye(3).tolist(), "T": shift}
    (folder / "eyes.json").write_text(json.dumps(eye))
    (folder / "chain.yaml").write_text(
        "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.05, -0.01, 0.003, -0.001]\n"
        "  distortion_model: equidistant\n  intrinsics: [40.0, 40.0, 32.0, 24.0]\n  resolution: [64, 48]\n"
    )
    image = np.asarray(Image.open(folder / "picture.png"))
    for eye_name, moved in (("left", 0), ("right", -3)):
        (folder / "eyes" / eye_name).mkdir(parents=True)
        Image.fromarray(np.roll(image, moved, axis=1)).save(folder / "eyes" / eye_name / "0.png")


def _dicom(folder: Path) -> None:
    """Small ones, of which the header is a good part."""
    size = (24, 16)
    kinds, frames = stills(picture(*size)), [picture(*size, seed) for seed in range(3)]
    for name, kind in (("still", "rgb"), ("runs", "rle"), ("jpeg", "jpeg"), ("jpeg2000", "jpeg 2000")):
        saved(kinds[kind][0], folder / f"{name}.dcm")
    for name, syntax, codec in (("lossless", JPEGLosslessSV1, "ljpeg"), ("jpegls", JPEGLSLossless, "jpegls")):
        form = "bgr24" if codec == "ljpeg" else "rgb24"
        packed = compressed(
            with_pixels(labelled(syntax=syntax), frames[0]), [lossless(frames[0], codec, form)]
        )
        saved(packed, folder / f"{name}.dcm")
    saved(with_pixels(labelled(VIDEO), np.stack(frames)), folder / "frames.dcm")
    content = video_file(folder / "film.mp4", frames)
    saved(video(content, size, len(frames), "40", fragments=2), folder / "film.dcm")
    main(["enhance", str(folder / "still.dcm"), str(folder / "enhanced.dcm")])


def _exports(folder: Path, run: RunFolder) -> None:
    main(["export", str(run.path), "--ply", str(folder / "ply"), "--frames", "0"])
    main(["export", str(run.path), "--video", str(folder / "export.mp4"), "--with", "cpu"])
    for path in (folder / "ply").glob("*.ply"):
        path.replace(folder / "export.ply")
    main(["export", str(run.path), "--glb", str(folder / "glb"), "--frames", "0"])
    for path in (folder / "glb").glob("*.glb"):
        path.replace(folder / "export.glb")
    _spz(folder / "export.spz")
    (folder / "export.splat").write_bytes(np.random.default_rng(1).bytes(32 * 40))
    (folder / "export.sog").write_bytes(bundled(sog(gaussians(40, 3))))
    (folder / "export.ksplat").write_bytes(ksplat(gaussians(40, 3)))
    planes = [np.random.default_rng(2).bytes(30 * width) for width in (9, 1, 3, 3, 4, 9)]
    (folder / "export-4.spz").write_bytes(spz_streams(1, planes, count=30))


def _spz(path: Path) -> None:
    import gzip
    import struct

    head = struct.pack("<IIIBBBB", 0x5053474E, 2, 30, 1, 12, 0, 0)
    path.write_bytes(gzip.compress(head + np.random.default_rng(2).bytes(30 * (9 + 1 + 3 + 3 + 3 + 9))))
