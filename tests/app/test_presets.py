"""Runs on frames that the preset `vessel` enhanced, and records that tell the two methods apart."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.trained_clip import input_clip
from enhance import measure
from enhance.metrics import dvbv_otsu
from enhance.vessel import VesselParams, enhance_vessels
from renderer.sources import open_clip
from tests.app.conftest import Cli


def test_a_run_on_frames_of_the_preset_goes_through_every_command(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    run, steps = tmp_path / "run", ("--iterations", 30, "--seed", 3)
    enhanced = ("--input", "enhanced", "--preset", "vessel")
    call = vesselsplat("train", clip_path, "--run", run, *enhanced, *steps, "--json")
    assert call.code == 0
    record, clip = RunFolder(run).record(), open_clip(clip_path)
    frames = [clip.read_frame(index) for index in clip.train_indices]
    pooled = measure([f.image for f in frames], tissue_masks=[f.tissue_mask for f in frames])
    assert record.enhancement is not None
    assert record.enhancement.params == VesselParams()
    assert record.enhancement.statistics == pooled
    assert json.loads(call.out)["enhancement"]["params"]["strength"] == VesselParams().strength
    expected = enhance_vessels(clip.read_image(1), statistics=pooled).image
    assert np.array_equal(input_clip(clip, record).read_image(1), expected)
    report = json.loads(vesselsplat("evaluate", run, "--json").out)
    assert report["frames"][0]["input_photo"]["dv"] == pytest.approx(
        dvbv_otsu(expected, tissue_mask=clip.read_frame(1).evaluation_mask).dv
    )
    assert vesselsplat("render", run, "--out", tmp_path / "out", "--frames", "test").code == 0
    resumed = vesselsplat("train", clip_path, "--run", run, *enhanced, *steps, "--resume")
    assert resumed.code == 0
    own = vesselsplat("train", clip_path, "--run", run, "--resume")
    assert (own.code, "the run is finished already" in own.error) == (0, True)
    refused = vesselsplat("train", clip_path, "--run", run, "--preset", "paper", "--resume")
    assert (refused.code, refused.error.count("\n")) == (2, 1)
    assert "expected the run's preset vessel, got paper" in refused.error


def test_a_preset_without_enhanced_frames_is_refused(
    clip_path: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    call = vesselsplat("train", clip_path, "--run", tmp_path / "run", "--preset", "vessel")
    assert (call.code, call.error.count("\n")) == (2, 1)
    assert "--preset has no effect with --input original" in call.error
    assert not (tmp_path / "run").exists()


OLD_PARAMS = (
    '{"z": null, "p": null, "p_form": "literal", "radii": [4, 16, 64], "eps": 0.0025, "subsample": 2, '
    '"d_factor": 0.5, "keep_black": true, "omit_below": 0.5}'
)


def test_records_of_the_paper_s_method_alone_are_still_read(runs: dict[str, Path], tmp_path: Path) -> None:
    run, text = RunFolder(tmp_path), RunFolder(runs["enhanced"]).record_path.read_text()
    whole = json.loads(text)
    whole["enhancement"]["params"] = json.loads(OLD_PARAMS)
    run.record_path.write_text(json.dumps(whole))
    assert run.record() == RunFolder(runs["enhanced"]).record()
    for params in ({"strength": 9}, {"z": 9}, {"lift": 1, "z": 0.5}, 5):
        whole["enhancement"]["params"] = params
        run.record_path.write_text(json.dumps(whole))
        with pytest.raises(UserError, match=r"run\.json: enhancement\.params") as refused:
            run.record()
        assert "\n" not in str(refused.value)
