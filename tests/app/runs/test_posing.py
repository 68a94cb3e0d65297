"""Training estimates the camera poses that a clip lacks, and everything after it uses them."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from app.commands.described.files import of_run
from app.evaluation.evaluate import open_evaluation
from app.files.stepping import run_to_end
from app.gui.work.opening import OpenRequest, open_path
from app.runs.clip_selection import ClipPart
from app.runs.posing import through_found
from app.runs.posing import unposed as without_poses
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from app.runs.trained_clip import run_clip
from app.scenes.scene import open_scene
from renderer.phantom import PhantomParams, write_phantom
from renderer.poses.rigid_motion import zoomed
from renderer.poses.search import FoundPoses, PosesError
from renderer.poses.told_apart import TISSUE
from renderer.poses.zooming import ONE_LENS, Zoom
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, FoundLens, LensCalibration
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from renderer.train.events import Started, Warned

CONFIG = TrainConfig(iterations=4, n_gaussians=500)


@pytest.fixture(scope="module")
def trained(unposed, tmp_path_factory):
    path = tmp_path_factory.mktemp("trained") / "run"
    events = list(run_training(TrainRequest(clip_path=unposed, run_path=path, config=CONFIG)))
    return RunFolder(path), events


def test_poses_are_recorded_with_how_well_they_fit(trained):
    record = trained[0].record()
    assert len({camera.position.tobytes() for camera in record.cameras}) == 12
    assert max(each for each in record.clip.poses.residuals if each is not None) < 1
    said = [event.message for event in trained[1] if isinstance(event, Warned)]
    tissue = TISSUE[record.clip.poses.tissue]
    assert any(m.startswith("camera poses are estimated") and m.endswith(tissue) for m in said)


def test_evaluation_and_the_window_see_through_them(trained):
    run = trained[0]
    cameras = run.record().cameras
    assert run_clip(run.record()).read_frame(7).camera == cameras[7]
    assert open_evaluation(run.path).clip.cameras == cameras
    *_, opened = open_path(OpenRequest(run.path))
    assert opened.clip.cameras == cameras
    assert opened.run.model.is_of(opened.clip)


def test_a_run_is_of_its_clip_as_that_was_opened_whatever_was_found_of_the_lens(trained, unposed):
    """As beside a training that has just ended in the window."""
    scene, clip = open_scene(trained[0].path), open_clip(unposed)
    zooming = tuple(zoomed(camera, 0.02 * at) for at, camera in enumerate(scene.cameras))
    assert scene.is_of(clip)
    assert replace(scene, cameras=zooming).is_of(clip)
    # An undistorted image is another one.
    lens = LensCalibration(fx=60, fy=60, cx=79.5, cy=63.5, distortion=(-0.2, 0, 0, 0))
    undistorted = replace(
        scene.record.clip, calibration=Calibration(lens=lens, found=FoundLens(deviation=0.01))
    )
    record = replace(scene.record, clip=undistorted)
    assert replace(scene, record=record).is_of(clip)
    assert not replace(scene, record=record, cameras=zooming).is_of(clip)
    assert not scene.is_of(clip.between(0, 5))
    assert not replace(scene, poses_are_estimated=False).is_of(clip)


def test_a_run_resumes_with_the_poses_that_it_began_with(unposed, tmp_path):
    request = TrainRequest(clip_path=unposed, run_path=tmp_path / "run", config=CONFIG)
    events = run_training(request)
    next(event for event in events if isinstance(event, Started))
    events.close()
    before = RunFolder(request.run_path).record()
    list(run_training(replace(request, resume=True)))
    assert RunFolder(request.run_path).record() == before
    assert before.clip.poses is not None


def test_a_run_that_began_without_poses_goes_on_without_whatever_is_found_by_now(
    unposed, tmp_path, monkeypatch
):
    """As of an earlier version, which could not follow the camera."""

    def lost(clip, tell):
        raise PosesError("the camera could not be followed")

    request = TrainRequest(clip_path=unposed, run_path=tmp_path / "run", config=CONFIG)
    with monkeypatch.context() as before:
        before.setattr("app.runs.posing.find_poses", lost)
        events = run_training(request)
        next(event for event in events if isinstance(event, Started))
        events.close()
    record = RunFolder(request.run_path).record()
    assert record.clip.poses is None
    told = list(run_training(replace(request, resume=True)))
    assert any("poses are missing" in event.message for event in told if isinstance(event, Warned))
    assert RunFolder(request.run_path).record() == record
    assert RunFolder(request.run_path).is_finished


def test_where_the_camera_moves_and_depth_is_guessed_the_way_to_poses_is_said(unposed, monkeypatch):
    monkeypatch.setattr("app.runs.posing.camera_motion", lambda _: "the background moves by 9 %")
    said = {}
    for depth in ("brightness", "measured"):
        clip = open_clip(unposed, ClipOptions(depth=depth))
        (said[depth],) = run_to_end(without_poses(clip, CONFIG)).notices
    few = open_clip(unposed, ClipOptions(depth="brightness")).between(0, 2)
    (short,) = run_to_end(without_poses(few, CONFIG)).notices
    assert said["measured"].endswith("camera poses are missing")  # They are looked for next.
    assert said["brightness"] == f"{said['measured']}; depth from motion finds them (--depth motion)"
    assert short == said["measured"]


def test_poses_can_be_refused_and_are_left_out_where_the_camera_is_fixed(unposed, tmp_path):
    refused = replace(CONFIG, leave_out=("poses",))
    told = list(run_training(TrainRequest(clip_path=unposed, run_path=tmp_path / "refused", config=refused)))
    assert any("poses are missing" in event.message for event in told if isinstance(event, Warned))
    assert RunFolder(tmp_path / "refused").record().clip.poses is None

    write_phantom(tmp_path / "still", PhantomParams(n_frames=10, width=64, height=48))
    events = run_training(
        TrainRequest(clip_path=tmp_path / "still", run_path=tmp_path / "run", config=CONFIG)
    )
    started = next(event for event in events if isinstance(event, Started))
    events.close()
    assert ("camera poses", "no motion of the camera was found") in {(o.what, o.why) for o in started.omitted}


def test_a_zoom_is_said_with_its_frames_and_each_frame_keeps_its_lens(unposed):
    clip = open_clip(unposed)
    zoom = Zoom(np.array([2, 9]), np.array([0.0, np.log(1.12)]))
    cameras = tuple(zoomed(clip.cameras[0], zoom.at(at)) for at in range(12))
    found = FoundPoses(0, cameras, (0.5,) * 12, (200,) * 12, (), zoom=zoom)
    through = through_found(clip, found, 0)
    small, large = clip.labels[2], clip.labels[9]
    said = f"the lens zooms: by 12 % from frame {small} to frame {large}"
    assert [note for note in through.notices if note.startswith(said)]
    assert through.clip.cameras == cameras
    assert through.clip.read_frame(9).camera.fx == pytest.approx(1.12 * clip.cameras[0].fx)
    assert not any("zooms" in note for note in through_found(clip, replace(found, zoom=ONE_LENS), 0).notices)


def test_where_a_path_is_closed_is_said_with_its_frames(unposed):
    clip = open_clip(unposed)
    found = FoundPoses(0, clip.cameras, (0.5,) * 12, (200,) * 12, (), closed=((1, 10), (2, 9)))
    said = (
        f"frames {clip.labels[1]} and {clip.labels[10]} show the same place: "
        "the path of the camera is closed there, by 2 pairs of frames"
    )
    assert said in through_found(clip, found, 0).notices
    assert not any("same place" in note for note in through_found(clip, replace(found, closed=()), 0).notices)


def test_info_says_by_how_much_the_lens_of_a_run_zooms(trained, tmp_path):
    run = shutil.copytree(trained[0].path, tmp_path / "run")
    before = {fact.name: fact for fact in of_run(run)}["poses"]
    assert "zooms" not in before.text
    assert before.value["zoom"] == 1
    record = json.loads((run / "run.json").read_text())
    record["clip"]["cameras"][5]["fx"] *= 1.2
    (run / "run.json").write_text(json.dumps(record))
    after = {fact.name: fact for fact in of_run(run)}["poses"]
    assert after.text == f"{before.text}; the lens zooms, by up to 20 %"
    assert after.value["zoom"] == pytest.approx(1.2)


def test_the_part_that_holds_is_what_is_trained_on(unposed, tmp_path):
    """Frames without anything to follow at the start are left out."""
    clip = tmp_path / "clip"
    shutil.copytree(unposed, clip)
    for image in sorted((clip / "images").iterdir())[:2]:
        Image.fromarray(np.zeros((128, 160, 3), np.uint8)).save(image)
    config = replace(CONFIG, keep=("poses",))
    request = TrainRequest(clip_path=clip, run_path=tmp_path / "run", config=config)
    list(run_training(request))
    record = RunFolder(request.run_path).record()
    assert record.clip.part.trim == (2, 11)
    assert record.clip.frames == len(run_clip(record)) == 10
    assert [each.frame for each in record.clip.poses.lost] == [0, 1]
    trimmed = replace(request, run_path=tmp_path / "trimmed", part=ClipPart(trim=(1, 11)))
    said = [event.message for event in run_training(trimmed) if isinstance(event, Warned)]
    assert RunFolder(trimmed.run_path).record().clip.part.trim == (2, 11)
    assert "only frames 3 to 12 are reconstructed, the longest part with camera poses" in said
    list(run_training(replace(request, resume=True)))


def test_frames_that_are_bridged_are_neither_trained_on_nor_measured(unposed, tmp_path):
    clip = tmp_path / "clip"
    shutil.copytree(unposed, clip)
    for image in sorted((clip / "images").iterdir())[8:10]:
        Image.fromarray(np.zeros((128, 160, 3), np.uint8)).save(image)
    config = replace(CONFIG, keep=("poses",))
    request = TrainRequest(clip_path=clip, run_path=tmp_path / "run", config=config)
    said = [event.message for event in run_training(request) if isinstance(event, Warned)]
    assert any("of their own are neither trained on nor measured: " in message for message in said)
    record = RunFolder(request.run_path).record()
    assert record.clip.poses.bridged == (8, 9)
    assert record.clip.part.tools is None
    seen = run_clip(record)
    assert seen.train_indices == (0, 2, 3, 4, 5, 6, 7, 10, 11)
    assert seen.test_indices == record.test_indices == (1,)
    assert seen.between(7, 11).train_indices == (0, 3, 4)
    assert seen.read_frame(9).tissue_mask.any()
    (one,) = open_evaluation(request.run_path).frames()
    assert one.psnr > 10
    list(run_training(replace(request, resume=True)))
    before = replace(record.clip, poses=replace(record.clip.poses, bridged=()))
    assert replace(record, clip=before).clip.as_trained(open_clip(clip)).test_indices == (1, 9)
