"""`evaluate`: table and JSON, LPIPS with weights and without, two runs beside each other and the paper."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.evaluate import compared
from app.evaluation.evaluate import Stopwatch, measure_frame, open_evaluation
from app.report.paper_rows import PAPER
from app.runs.processor import load_average
from app.runs.run_folder import RunFolder
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from enhance.metrics import line_scale, vessel_contrast
from enhance.ridges import vessel_mask
from renderer.clip import Clip
from renderer.lpips import LAYERS, read_lpips
from renderer.metrics import depth_abs_rel
from renderer.near_plane import near_plane
from renderer.phantom import PhantomParams, write_phantom
from renderer.rasterize.rendered import Rendered
from renderer.sources import open_clip
from renderer.train.config import CHOSEN
from tests.app.conftest import Cli

PULLING = Path(__file__).resolve().parents[3] / "../shared/data/endonerf/pulling_soft_tissues"


@pytest.fixture(autouse=True)
def no_weights_of_this_user(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("VESSELSPLAT_LPIPS", raising=False)
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_: tmp_path / "cache")


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Random weights of LPIPS."""
    import torch

    folder = tmp_path_factory.mktemp("weights")
    generator = torch.Generator().manual_seed(2)
    network, heads = {}, {}
    for index, layer in enumerate(LAYERS):
        spread = math.sqrt(2 / math.prod(layer.shape[1:]))
        network[f"features.{layer.number}.weight"] = spread * torch.randn(layer.shape, generator=generator)
        network[f"features.{layer.number}.bias"] = torch.zeros(layer.shape[0])
        heads[f"lin{index}.model.1.weight"] = torch.rand((1, layer.shape[0], 1, 1), generator=generator)
    torch.save(network, folder / "alexnet-owt-0.pth")
    torch.save(heads, folder / "alex.pth")
    return folder


def evaluated(vesselsplat: Cli, *arguments: object) -> dict[str, Any]:
    call = vesselsplat("evaluate", *arguments, "--json")
    assert call.code == 0, call.error
    report: dict[str, Any] = json.loads(call.out)
    return report


def test_depth_error_and_shares_are_of_the_evaluated_pixels(runs: dict[str, Path], vesselsplat: Cli) -> None:
    report = evaluated(vesselsplat, runs["enhanced"])
    evaluation = open_evaluation(runs["enhanced"])
    row, frame = report["frames"][1], evaluation.trained_clip.read_frame(9)
    drawn = draw_on_cpu(
        evaluation.model.at(frame.time), frame.camera, DrawOptions(near_plane(evaluation.model, frame.camera))
    )
    mask = frame.evaluation_mask
    assert frame.depth is not None
    assert row["depth"]["abs_rel"] == depth_abs_rel(drawn.depth, frame.depth, mask)
    assert 0 < row["depth"]["covered"] <= 1
    assert 0 < mask.mean() < 1
    assert row["evaluated_share"] == mask.mean()
    for group in ("depth", "visibility", "parts_ms", "whole_picture", "input_photo"):
        for name, mean in report[group].items():
            finite = [each[group][name] for each in report["frames"] if each[group][name] is not None]
            assert mean == (pytest.approx(np.mean(finite)) if finite else None)
    assert (report["seed"], report["evaluation_masks"]) == (0, "masks")
    assert report["timed_with"]["threads"] >= 1
    assert report["timed_with"]["load"] >= 0


def test_a_system_without_a_load_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """As Windows, where psutil would say 0."""
    monkeypatch.delattr("os.getloadavg")
    assert load_average() is None


@pytest.fixture(scope="module")
def large_clip(tmp_path_factory: pytest.TempPathFactory) -> Clip:
    """Large enough for ridges."""
    path = tmp_path_factory.mktemp("large") / "clip"
    write_phantom(path, PhantomParams(n_frames=2, width=256, height=192, seed=3), "endonerf")
    return open_clip(path)


def test_the_frame_itself_is_a_perfect_render(large_clip: Clip) -> None:
    frame = large_clip.read_frame(1)
    assert frame.depth is not None
    render = Rendered(frame.image.astype(np.float32) / 255, np.ones_like(frame.depth), frame.depth)
    measures = measure_frame(frame, render, large_clip, None, {"raster": 2.0, "deformation": 1.0})
    assert measures.psnr == measures.psnr_masked == math.inf
    assert measures.ssim == pytest.approx(1)
    assert measures.depth_rmse_mm == 0
    assert measures.depth == {"abs_rel": 0, "covered": 1}
    assert measures.ms_per_frame == 3
    own = {name: getattr(measures, name) for name in ("dv", "bv", "dv_bv")} | measures.visibility
    assert own == measures.input_photo == measures.original_photo
    assert measures.visibility["vessel_contrast"] > 0


def test_tissue_counts_where_no_depth_was_measured_and_the_seldom_seen_by_itself(large_clip: Clip) -> None:
    frame = large_clip.read_frame(1)
    evaluated, seldom = frame.tissue_mask.copy(), np.zeros_like(frame.tissue_mask)
    seldom[:, :40], evaluated[:, :60] = True, False
    image, alpha = frame.image.astype(np.float32) / 255, np.ones(evaluated.shape, np.float32)
    image[:, :40], alpha[:, :20] = image[:, :40] * 0.5, 0.5
    partly = replace(frame, evaluation_mask=evaluated)
    measures = measure_frame(partly, Rendered(image, alpha, alpha), large_clip, None, {}, seldom)
    assert measures.psnr_masked == math.inf
    left = frame.tissue_mask & seldom
    error = np.square(np.rint(image * 255) / 255 - frame.image / 255)
    assert measures.psnr_seldom == pytest.approx(-10 * math.log10(error[left].mean()))
    assert measures.psnr_tissue == pytest.approx(-10 * math.log10(error[frame.tissue_mask].mean()))
    assert measures.coverage == pytest.approx(1 - frame.tissue_mask[:, :20].sum() / frame.tissue_mask.sum())


def test_what_is_seldom_seen_is_so_in_few_training_frames(runs: dict[str, Path]) -> None:
    evaluation = open_evaluation(runs["original"])
    shown = np.mean(
        [evaluation.clip.read_frame(index).tissue_mask for index in evaluation.clip.train_indices], axis=0
    )
    np.testing.assert_array_equal(evaluation.seldom, (shown > 0) & (shown <= 0.3))
    moving = replace(evaluation.clip.cameras[0], cx=1.0)
    moved = replace(evaluation.clip, cameras=(moving, *evaluation.clip.cameras[1:]))
    assert replace(evaluation, clip=moved).seldom is None


def test_the_ridges_are_those_of_the_original_frame(large_clip: Clip) -> None:
    frame = large_clip.read_frame(1)
    mask = frame.evaluation_mask
    scale = line_scale(frame.image)
    assert scale < 1
    ridges = vessel_mask(frame.image, tissue_mask=mask, scale=scale)
    darker = np.where(ridges[..., None], frame.image // 2, frame.image)
    empty = np.zeros(mask.shape, np.float32)
    shown = Rendered(darker.astype(np.float32) / 255, empty, empty)
    # The frame that a run was trained on has vessels elsewhere, which must not matter.
    turned = replace(frame, image=np.ascontiguousarray(frame.image[::-1]))
    measures = measure_frame(turned, shown, large_clip, None, {})
    assert measures.visibility["vessel_contrast"] == vessel_contrast(
        darker, ridges, tissue_mask=mask, scale=scale
    )
    assert measures.visibility["vessel_contrast"] > measures.original_photo["vessel_contrast"] + 0.3
    # A render without any depth has no depth error, and says how little was compared.
    assert math.isnan(measures.depth_rmse_mm)
    assert measures.depth["covered"] == 0


def test_the_two_psnr_differ_by_the_evaluated_share_on_a_constant_error(large_clip: Clip) -> None:
    frame = large_clip.read_frame(1)
    image = np.clip(frame.image, 0, 245)
    flat = np.ones(image.shape[:2], np.float32)
    raised = Rendered((image + 10).astype(np.float32) / 255, flat, flat)
    measures = measure_frame(replace(frame, image=image), raised, large_clip, None, {})
    assert measures.psnr_masked == pytest.approx(-20 * math.log10(10 / 255))
    gap = -10 * math.log10(measures.evaluated_share)
    assert gap > 0.1
    assert measures.psnr - measures.psnr_masked == pytest.approx(gap, abs=1e-9)


def test_the_stopwatch_draws_what_is_drawn_elsewhere_and_its_parts_add_up(runs: dict[str, Path]) -> None:
    evaluation = open_evaluation(runs["original"])
    frame = evaluation.trained_clip.read_frame(1)
    drawn, parts = Stopwatch(evaluation.model, frame.camera).draw(frame)
    other = draw_on_cpu(
        evaluation.model.at(frame.time), frame.camera, DrawOptions(near_plane(evaluation.model, frame.camera))
    )
    assert np.array_equal(drawn.image, other.image)
    assert np.array_equal(drawn.depth, other.depth)
    assert list(parts) == ["deformation", "projection_sort", "raster"]
    assert parts["deformation"] > 0
    assert parts["projection_sort"] > 0
    (first, _) = evaluation.frames()
    assert first.ms_per_frame == pytest.approx(sum(first.parts_ms.values()))


MEMORY = """
import numpy as np
from app.runs.memory import peak_memory_mb

before = peak_memory_mb()
held = np.ones(20_000_000)
print(before, peak_memory_mb())
"""


def test_peak_memory_is_that_of_one_process_and_grows_with_what_it_holds() -> None:
    # 480 MB here: a process that is spawned must not begin with them.
    held = np.ones(60_000_000)
    done = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True)
    before, after = map(float, done.stdout.split())
    assert 10 < before < held.nbytes / 1e6
    assert after - before == pytest.approx(160, abs=40)


def test_the_frames_are_told_by_the_split_of_the_run(
    runs: dict[str, Path], clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    flags = ("--run", tmp_path / "run", "--iterations", 3, "--split", "even-odd")
    assert vesselsplat("train", clip_path, *flags).code == 0
    for run, frames, held_out in (
        (runs["original"], [1, 9], "(index - 1) % 8 == 0"),
        (tmp_path / "run", [1, 3, 5, 7, 9], "those of odd index"),
    ):
        report = evaluated(vesselsplat, run)
        assert [frame["index"] for frame in report["frames"]] == frames
        assert report["definitions"]["frames_are"].startswith(f"test: held out, {held_out}; ")


def test_peak_memory_of_training_is_what_the_run_logged(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    copy = RunFolder(tmp_path / "copy")
    shutil.copytree(runs["original"], copy.path)
    lines = [json.loads(line) for line in copy.events_path.read_text().splitlines()]
    for logged in ({}, {"peak_memory_mb": 512.5}):
        lines[-1] = {name: value for name, value in lines[-1].items() if name != "peak_memory_mb"} | logged
        copy.events_path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        report = evaluated(vesselsplat, copy.path)
        assert report["peak_memory_mb"]["training"] == logged.get("peak_memory_mb")
        assert report["peak_memory_mb"]["evaluation"] > 0


def test_lpips_is_measured_with_weights_given_named_or_cached(
    runs: dict[str, Path], weights: Path, tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = runs["original"]
    given = evaluated(vesselsplat, run, "--lpips-weights", weights)
    frame = open_evaluation(run).trained_clip.read_frame(9)
    drawn, _ = Stopwatch(RunFolder(run).model(), frame.camera).draw(frame)
    mask, pair = frame.evaluation_mask, (drawn.bytes / 255, frame.image / 255)
    assert given["frames"][1]["lpips"] == pytest.approx(read_lpips(weights).distance(*pair, mask))
    assert given["mean"]["lpips"] > 0
    assert "AlexNet" in given["definitions"]["lpips"]
    with monkeypatch.context() as named:
        named.setenv("VESSELSPLAT_LPIPS", str(weights))
        assert evaluated(vesselsplat, run)["mean"]["lpips"] == given["mean"]["lpips"]
    shutil.copytree(weights, tmp_path / "cache" / "lpips")
    assert evaluated(vesselsplat, run)["mean"]["lpips"] == given["mean"]["lpips"]


def test_without_weights_lpips_is_null_and_says_what_to_do(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    report = evaluated(vesselsplat, runs["original"])
    assert report["mean"]["lpips"] is None
    assert report["definitions"]["lpips"].startswith("not measured: put alexnet")
    assert str(tmp_path) not in json.dumps(report)
    text = " ".join(vesselsplat("evaluate", runs["original"]).out.split())
    assert "LPIPS: not measured: put alexnet*.pth" in text


def test_weights_that_are_not_where_they_are_said_to_be_are_one_line(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    call = vesselsplat("evaluate", runs["original"], "--lpips-weights", tmp_path / "nowhere")
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "nowhere" in call.error
    monkeypatch.setenv("VESSELSPLAT_LPIPS", str(tmp_path))
    call = vesselsplat("evaluate", runs["original"])
    assert (call.code, call.error.count("\n"), "alexnet" in call.error) == (2, 1, True)


def test_torch_is_not_loaded_where_there_are_no_weights(runs: dict[str, Path], tmp_path: Path) -> None:
    script = (
        "import sys, platformdirs; from pathlib import Path; from app.__main__ import main\n"
        f"platformdirs.user_cache_path = lambda *_: Path({str(tmp_path)!r})\n"
        f"assert main(['evaluate', {str(runs['original'])!r}]) == 0\n"
        "assert 'torch' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)


def test_the_table_fits_a_narrow_terminal_and_is_aligned(
    runs: dict[str, Path], weights: Path, vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    out = vesselsplat("evaluate", runs["original"], "--lpips-weights", weights).out
    lines = [line.rstrip() for line in out.splitlines()]
    assert max(map(len, lines)) <= 80
    heading = next(line for line in lines if "PSNR" in line)
    rows = [line for line in lines if line.split()[:1] in (["1"], ["9"], ["mean"])]
    assert len(rows) == 3
    assert len({len(line) for line in rows}) == 1
    assert len(heading.rstrip()) == len(rows[0])
    report = evaluated(vesselsplat, runs["original"], "--lpips-weights", weights)
    for row, mean in zip(rows, (*report["frames"], report["mean"]), strict=True):
        numbers = row.split()
        assert numbers[1] == f"{mean['psnr']:.2f}"
        assert numbers[4] == f"{mean['lpips']:.4f}"
        assert len(numbers) == 11


def test_two_runs_stand_beside_each_other(runs: dict[str, Path], vesselsplat: Cli) -> None:
    report = evaluated(vesselsplat, runs["enhanced"], "--against", runs["original"])
    alone = {name: evaluated(vesselsplat, path) for name, path in runs.items()}
    assert (report["input"], report["against"]["input"]) == ("enhanced", "original")
    for name, side in (("enhanced", report), ("original", report["against"])):
        kept = {key: value for key, value in side["mean"].items() if key != "ms_per_frame"}
        assert kept.items() <= alone[name]["mean"].items()
    gain = report["compared"]["dv_bv_gain"]
    ratio = alone["enhanced"]["mean"]["dv_bv"] / alone["original"]["mean"]["dv_bv"]
    assert gain["render"] == pytest.approx(ratio)
    whole = [alone[name]["whole_picture"]["dv_bv"] for name in ("enhanced", "original")]
    assert gain["whole_picture"] == pytest.approx(whole[0] / whole[1])
    assert report["compared"]["paper"] == []
    out = vesselsplat("evaluate", runs["enhanced"], "--against", runs["original"]).out
    assert f"{gain['render']:.2f} times that of original" in out
    assert "EndoGaussian" not in out


def test_runs_of_two_clips_are_not_compared(runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli) -> None:
    other = tmp_path / "other"
    write_phantom(other, PhantomParams(n_frames=3, width=64, height=48, seed=2), "endonerf")
    assert vesselsplat("train", other, "--run", tmp_path / "run", "--iterations", 2).code == 0
    call = vesselsplat("evaluate", runs["original"], "--against", tmp_path / "run")
    assert (call.code, call.out, call.error.count("\n")) == (2, "", 1)
    assert "run on the clip small, got one on other" in call.error


def test_the_paper_stands_beside_its_own_clips_only(runs: dict[str, Path]) -> None:
    clip = RunFolder(runs["original"]).record().clip
    undefined = {name: {"dv_bv": None} for name in ("mean", "whole_picture", "input_photo")}

    def methods(name: str, frames: int) -> list[str]:
        known = compared(undefined, undefined, replace(clip, name=name, frames=frames))
        return [row.method for row in known["paper"]]

    both = ["EndoGaussian", "EndoGaussian", "Deform3DGS", "Deform3DGS"]
    assert methods("pulling_soft_tissues", 63) == methods("cutting_tissues_twice", 156) == both
    assert methods("pulling_soft_tissues", 64) == methods("small", 63) == []


def test_the_rows_of_the_paper_agree_with_themselves() -> None:
    for before, after in zip(PAPER[::2], PAPER[1::2], strict=True):
        assert (before.input, after.input) == ("original", "enhanced")
        assert (before.clip, before.table, before.method) == (after.clip, after.table, after.method)
        for row in (before, after):
            # The paper's ratio is a mean of ratios: near the ratio of the means.
            assert row.dv / row.bv == pytest.approx(row.dv_bv, rel=0.03)


@pytest.mark.data
@pytest.mark.skipif(not PULLING.is_dir(), reason="the pulling clip is not here")
def test_the_pulling_clip_is_known_to_the_paper() -> None:
    clip = open_clip(PULLING)
    assert any(row.clip in clip.name and row.frames == len(clip) for row in PAPER)


def test_the_paper_is_printed_beside_the_runs_of_its_clip(
    runs: dict[str, Path], vesselsplat: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.console.progress.WIDTH", 80)
    monkeypatch.setenv("COLUMNS", "80")
    rows = tuple(replace(row, clip="small", frames=10) for row in PAPER[:4])
    monkeypatch.setattr("app.commands.evaluate.PAPER", rows)
    out = vesselsplat("evaluate", runs["enhanced"], "--against", runs["original"]).out
    lines = [line.rstrip() for line in out.splitlines()]
    assert max(map(len, lines)) <= 80
    (row,) = [line for line in lines if "Deform3DGS, enhanced" in line]
    assert row.split()[2:6] == ["0.0430", "871.1", "596.6", "1.470"]
    assert "the paper's Table 1, EndoGaussian: 1.45 times" in lines
    report = evaluated(vesselsplat, runs["enhanced"], "--against", runs["original"])
    row = report["compared"]["paper"][1]
    assert (row["table"], row["input"], row["dv"], row["bv"]) == (1, "enhanced", 427.55, 243.74)
    gains = {"Table 1, EndoGaussian": 1.76 / 1.21, "Table 2, Deform3DGS": 1.47 / 0.93}
    assert report["compared"]["paper_dv_bv_gain"] == pytest.approx(gains)


def test_definitions_say_what_depth_was_dropped_what_was_departed_from_and_what_was_chosen(
    runs: dict[str, Path], vesselsplat: Cli
) -> None:
    definitions = evaluated(vesselsplat, runs["original"])["definitions"]
    assert "more than 3 times as far as the frame's median" in definitions["depth_rmse_mm"]
    assert definitions["method"].startswith("`vesselsplat`")
    assert definitions["defaults"] == CHOSEN
