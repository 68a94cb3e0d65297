"""Tool masks that were made for a clip: left out by a run, which keeps copies of them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.__main__ import main
from app.errors import UserError
from app.evaluation.evaluate import open_evaluation
from app.runs.clip_selection import ClipPart
from app.runs.run_folder import RunFolder
from app.runs.tool_masks import FOLDER, ToolMasks
from app.runs.train_run import run_training
from app.runs.trained_clip import run_clip
from app.scenes.scene import open_scene
from renderer.clip import BoolImage
from renderer.sources import open_clip
from renderer.tools.mask_files import origin_of, write_mask
from renderer.train.config import TrainConfig
from renderer.train.events import Started, Warned
from tests.app.conftest import Cli, request_of
from tests.renderer.tools.onnx_files import write_convolution

CONFIG = TrainConfig(iterations=2, n_gaussians=500)


def corner(right: int = 20) -> BoolImage:
    mask = np.zeros((48, 64), bool)
    mask[:16, :right] = True
    return mask


def masks_for(clip: Path, folder: Path, frames: Iterator[int] | range) -> Path:
    folder.mkdir(parents=True)
    labels = open_clip(clip).labels
    for index in frames:
        write_mask(folder / f"{Path(labels[index]).stem}.png", corner(), "by hand")
    return folder


def of(folder: Path) -> ClipPart:
    return ClipPart(tool_masks=ToolMasks(folder=str(folder)))


def test_a_run_leaves_them_out_and_goes_on_with_its_own_copies(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    request = request_of(unmasked, tmp_path / "run", config=CONFIG, part=of(masks))
    list(run_training(request))
    shutil.rmtree(masks)
    shutil.move(tmp_path / "run", tmp_path / "elsewhere" / "moved")
    run = RunFolder(tmp_path / "elsewhere" / "moved")
    for index in range(10):
        frame = run_clip(run.record()).read_frame(index)
        np.testing.assert_array_equal(frame.tissue_mask, ~corner())
    assert run.record().clip.part.tools is None
    assert "without tools" in run.record().clip.part.told()
    written = json.loads(run.record_path.read_text())["clip"]["part"]["tool_masks"]
    assert written["folder"] == FOLDER


def test_it_is_said_where_masks_are_paired_in_order(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    for number, path in enumerate(sorted(masks.iterdir())):
        path.rename(masks / f"{number + 20}.png")
    said = [event.message for event in run_training(
        request_of(unmasked, tmp_path / "run", config=CONFIG, part=of(masks))
    ) if isinstance(event, Warned)]  # fmt: skip
    assert any(
        "masks/ are paired with the frames in order, not by name: 20.png with" in text for text in said
    )


def test_it_is_said_where_masks_mark_the_tissue(
    clip_path: Path, unmasked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    masks, whole = masks_for(unmasked, tmp_path / "masks", range(0)), open_clip(clip_path)
    for index, label in enumerate(whole.labels):
        write_mask(masks / f"{Path(label).stem}.png", whole.read_frame(index).tissue_mask, "by hand")
    told = ToolMasks(folder=str(masks)).told(open_clip(unmasked))
    assert told.notices[-1].startswith("masks in masks/ look inverted")
    assert main(["masks", str(unmasked), "--out", str(tmp_path / "out"), "--given", str(masks)]) == 0
    assert "masks in masks/ look inverted" in capsys.readouterr().out


def test_frames_without_a_mask_are_searched_and_trimming_mixes_none_up(
    unmasked: Path, tmp_path: Path
) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(2, 5))
    part = ClipPart(trim=(1, 8), tool_masks=ToolMasks(folder=str(masks)))
    list(run_training(request_of(unmasked, tmp_path / "run", config=CONFIG, part=part)))
    record = RunFolder(tmp_path / "run").record()
    seen = run_clip(record)
    assert record.clip.part.tools is not None
    assert record.clip.part.tools.looked_at < len(seen)
    for index in range(8):
        is_drawn = 2 <= index + 1 <= 4
        assert np.array_equal(seen.read_frame(index).tissue_mask, ~corner()) == is_drawn


def test_a_run_goes_on_with_the_same_masks_alone(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    flags = {"config": CONFIG, "part": of(masks)}
    list(run_training(request_of(unmasked, tmp_path / "run", **flags)))
    (tmp_path / "run" / "model.safetensors").unlink()
    list(run_training(request_of(unmasked, tmp_path / "run", resume=True, **flags)))
    list(run_training(request_of(unmasked, tmp_path / "run", resume=True, config=CONFIG)))
    write_mask(next(masks.iterdir()), corner(30), "by hand")
    with pytest.raises(UserError, match="cannot resume: expected the run's tool_masks of digest"):
        list(run_training(request_of(unmasked, tmp_path / "run", resume=True, **flags)))


def test_what_is_mended_while_a_run_goes_on_is_for_the_next_one(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    events = run_training(request_of(unmasked, tmp_path / "run", config=CONFIG, part=of(masks)))
    next(event for event in events if isinstance(event, Started))
    shutil.rmtree(masks)
    list(events)
    frame = run_clip(RunFolder(tmp_path / "run").record()).read_frame(7)
    np.testing.assert_array_equal(frame.tissue_mask, ~corner())


def test_lossy_masks_are_copied_as_what_they_mean(unmasked: Path, tmp_path: Path) -> None:
    (tmp_path / "masks").mkdir()
    for label in open_clip(unmasked).labels:
        grey = Image.fromarray(corner().astype(np.uint8) * 255)
        grey.save(tmp_path / "masks" / f"{Path(label).stem}.jpg", quality=30)
    list(run_training(request_of(unmasked, tmp_path / "run", config=CONFIG, part=of(tmp_path / "masks"))))
    frame = run_clip(RunFolder(tmp_path / "run").record()).read_frame(7)
    assert np.mean(frame.tissue_mask != ~corner()) < 0.01


def test_copies_that_a_killed_run_lacks_are_made_when_it_goes_on(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    flags = {"config": CONFIG, "part": of(masks)}
    list(run_training(request_of(unmasked, tmp_path / "run", **flags)))
    shutil.rmtree(tmp_path / "run" / FOLDER)
    (tmp_path / "run" / "model.safetensors").unlink()
    list(run_training(request_of(unmasked, tmp_path / "run", resume=True, **flags)))
    assert len(list((tmp_path / "run" / FOLDER).iterdir())) == 10


def test_what_leaves_this_computer_names_no_folder(unmasked: Path, tmp_path: Path) -> None:
    masks = masks_for(unmasked, tmp_path / "masks", range(10))
    list(run_training(request_of(unmasked, tmp_path / "run", config=CONFIG, part=of(masks))))
    evaluation = open_evaluation(tmp_path / "run")
    part = evaluation.report([])["clip"]["part"]
    scene = open_scene(tmp_path / "run")
    assert scene.record.clip is not None
    for told in (part, scene.record.clip.part):
        assert told.tool_masks.folder == FOLDER
        assert told.tool_masks.sha256


def test_the_command_masks_and_training_takes_them(unmasked: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    made = vesselsplat("masks", unmasked, "--out", tmp_path / "found", "--json")
    told = json.loads(made.out)
    assert made.code == 0, made.error
    assert (told["with_tools"], told["given"], told["held_out"]) == (10, 0, None)
    assert told["agreement"] > 0.6
    given = masks_for(unmasked, tmp_path / "given", range(0, 9, 4))
    learned = vesselsplat("masks", unmasked, "--out", tmp_path / "learned", "--given", given)
    assert learned.code == 0, learned.error
    assert "10 masks" in learned.out
    assert "3 by hand, the others learned from them; IoU" in learned.out
    origins = [origin_of(path) for path in sorted((tmp_path / "learned").iterdir())]
    assert [place for place, origin in enumerate(origins) if origin == "by hand"] == [0, 4, 8]
    trained = vesselsplat(
        "train", unmasked, "--run", tmp_path / "run", "--iterations", 2, "--tool-masks", tmp_path / "learned"
    )
    assert trained.code == 0, trained.error
    assert "left out: tools" not in trained.error
    shutil.copytree(tmp_path / "run", tmp_path / "again")
    compared = vesselsplat("evaluate", tmp_path / "run", "--against", tmp_path / "again")
    assert compared.code == 0, compared.error


@pytest.mark.parametrize("flag", ["--given", "--tool-masks"])
def test_a_folder_without_masks_of_the_clip_is_refused_in_a_line(
    flag: str, unmasked: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    (tmp_path / "empty").mkdir()
    command = ("masks", "--out") if flag == "--given" else ("train", "--run")
    call = vesselsplat(command[0], unmasked, command[1], tmp_path / "out", flag, tmp_path / "empty")
    assert call.code == 2
    assert call.error.strip().splitlines()[-1].startswith("vesselsplat: expected masks named as the frames")
    assert not (tmp_path / "out").exists()


def test_masks_of_before_are_told_and_flags_without_their_network_refused(
    unmasked: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "old.png").write_bytes(b"")
    call = vesselsplat("masks", unmasked, "--out", out)
    assert (call.code, f"{out} also holds 1 file of this kind from before" in call.error) == (0, True)
    for flag, value in (("--onnx-tools", 3), ("--onnx-values", "imagenet")):
        call = vesselsplat("masks", unmasked, "--out", out, flag, value)
        assert (call.code, call.error) == (2, f"vesselsplat: {flag}: expected --onnx FILE with it\n")


def test_masks_are_not_written_among_what_they_are_made_of(
    unmasked: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    given = tmp_path / "given"
    given.mkdir()
    for flags, said in (
        (("--out", unmasked / "masks"), "outside of the clip"),
        (("--out", given, "--given", given), "another folder than --given"),
    ):
        call = vesselsplat("masks", unmasked, *flags)
        assert (call.code, said in call.error) == (2, True), call.error
    assert not (unmasked / "masks").exists()


def test_a_network_of_the_user_masks_tools(unmasked: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    pytest.importorskip("onnxruntime")
    weights = np.array([[0, 0, 0], [1, 0, 0]], np.float32)
    network = write_convolution(tmp_path / "net.onnx", weights, np.array([0, -2], np.float32))
    made = vesselsplat(
        "masks", unmasked, "--out", tmp_path / "out", "--onnx", network, "--onnx-values", "unit"
    )
    assert made.code == 0, made.error
    assert "10 masks, tools in 0" in made.out
    assert origin_of(next((tmp_path / "out").iterdir())) == "by a model"
    network.write_text("no network")
    refused = vesselsplat("masks", unmasked, "--out", tmp_path / "other", "--onnx", network)
    assert refused.code == 2
    assert "expected an ONNX network" in refused.error
    assert not (tmp_path / "other").exists()
