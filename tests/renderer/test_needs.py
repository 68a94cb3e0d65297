"""What is left out: decided right where the truth is known, told in numbers, forced back by name."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from renderer.clip import Clip, Frame
from renderer.deformation.motion import Still
from renderer.deformation.spline_motion import SplineMotion
from renderer.gaussians import DynamicGaussians
from renderer.phantom import Phantom, PhantomParams
from renderer.phantom.surface import grow_surface
from renderer.rasterize.cpu import render
from renderer.raw_gaussians import RawGaussians
from renderer.sources import open_clip
from renderer.train import needs as deciding
from renderer.train import trainer
from renderer.train.checkpoint import checkpoint_paths
from renderer.train.config import TrainConfig
from renderer.train.events import Finished, Started
from renderer.train.frames import halved, train_frame
from renderer.train.methods import recipe_for
from renderer.train.model import TrainModel
from renderer.train.needs import Needs, decide
from renderer.train.recipe import Recipe
from renderer.train.stillness import Stillness, stillness
from renderer.train.training import train
from renderer.train.unseen import seen_in, without_unseen
from tests.renderer.plane import N_FRAMES, plane_clip
from tests.renderer.sheet import finished, moving_sheet, needs_of, same_bytes

PULLING = Path(__file__).resolve().parents[2] / "../shared/data/endonerf/pulling_soft_tissues"
SMALL = TrainConfig(iterations=120, n_gaussians=800, checkpoint_every=30, hold_out=True)
KINDS = [(camera, tissue) for camera in ("fixed", "moving") for tissue in ("moving", "static")]


@cache
def painted(seed: int) -> Phantom:
    return Phantom(PhantomParams(n_frames=16, width=96, height=80, seed=seed, noise=1.5))


def phantom_frames(seed: int, camera: Any, tissue: Any) -> list[Frame]:
    """The frames to fit; the tissue of a seed is painted once for all four kinds."""
    phantom = copy(painted(seed))
    phantom.params = replace(phantom.params, camera=camera, tissue=tissue)
    phantom.surface = grow_surface(np.random.default_rng(seed), tissue == "moving", 1)
    return [phantom.view(index).frame for index in range(phantom.params.n_frames) if (index - 1) % 8]


def clip_of(frames: list[Frame]) -> Clip:
    return replace(plane_clip(), cameras=tuple(frame.camera for frame in frames))


def what(needs: Needs) -> set[str]:
    return {omission.what for omission in needs.omitted}


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
@pytest.mark.parametrize(("camera", "tissue"), KINDS)
def test_phantoms_of_all_kinds_get_what_they_need(seed: int, camera: str, tissue: str) -> None:
    frames = phantom_frames(seed, camera, tissue)
    needs = decide(clip_of(frames), frames, TrainConfig())
    assert needs.moves == (tissue == "moving")
    assert needs.recolors == ((camera, tissue) != ("fixed", "static"))
    assert needs.sh_degree == 0
    lit = decide(clip_of(frames), frames, TrainConfig(leave_out=("color_curves",)))
    assert lit.sh_degree == (0 if camera == "fixed" else 3)


@pytest.mark.data
@pytest.mark.skipif(not PULLING.is_dir(), reason="the pulling clip is not here")
def test_pulled_tissue_moves_before_a_fixed_camera() -> None:
    needs = needs_of(open_clip(PULLING), TrainConfig(hold_out=True))
    assert needs.moves
    assert needs.recolors
    assert needs.has_depth
    assert needs.has_masks
    assert needs.n_controls == 23
    assert what(needs) == {
        "harmonics",
        "control values",
        "updates of control values at other times",
        "tiles without tissue",
    }


def test_what_is_left_out_is_told_in_numbers() -> None:
    needs = needs_of(plane_clip(masked=True), SMALL)
    told = {omission.what: (omission.why, omission.saves) for omission in needs.omitted}
    assert told["harmonics"] == ("the camera is fixed", "45 of 59 numbers per Gaussian")
    assert told["deformation"][1] == told["colour curves"][1] == "18 numbers per Gaussian"
    assert told["tiles without tissue"][1] == "13 % of the tiles"  # 2 x 2 of 6 x 5
    assert "masking" not in told
    assert "masking" in what(needs_of(plane_clip(), SMALL))
    assert "updates of control values at other times" in what(
        needs_of(moving_sheet(), replace(SMALL, n_controls=7))
    )
    degree_1 = needs_of(plane_clip(), replace(SMALL, sh_degree=1))
    assert "36 of 59 numbers per Gaussian" in {omission.saves for omission in degree_1.omitted}


def test_without_depth_there_is_no_depth_loss() -> None:
    blind = needs_of(plane_clip(has_depth=False), SMALL)
    assert "depth loss" in what(blind)
    assert recipe_for(SMALL, blind).losses.depth == 0
    assert recipe_for(SMALL, needs_of(plane_clip(), SMALL)).losses.depth == SMALL.depth_weight


@pytest.mark.parametrize(
    ("part", "name"),
    [
        ("harmonics", "harmonics"),
        ("deformation", "deformation"),
        ("color_curves", "colour curves"),
        ("depth", "depth loss"),
        ("masks", "masking"),
    ],
)
def test_each_part_is_forced_back_by_its_name(part: Any, name: str) -> None:
    """On a clip that needs none of them."""
    clip = plane_clip(has_depth=False)
    needs, kept = needs_of(clip, SMALL), needs_of(clip, replace(SMALL, keep=(part,)))
    assert what(needs) - what(kept) == {name}


def test_tiles_and_control_values_are_forced_back() -> None:
    config = replace(SMALL, keep=("tiles", "controls"))
    clip = plane_clip(slide=2.0, masked=True)
    assert {"tiles without tissue", "control values"} <= what(needs_of(clip, SMALL))
    assert not {"tiles without tissue", "control values"} & what(needs_of(clip, config))
    assert needs_of(clip, config).n_controls == N_FRAMES
    assert recipe_for(config, needs_of(clip, config)).every_tile


def test_moments_are_forced_back() -> None:
    """Far from a frame's time a control value rests, or goes on as Adam is published."""
    clip = moving_sheet()
    far = []
    for keep in ((), ("moments",)):
        config = replace(SMALL, n_controls=8, keep=keep)
        assert ("updates of control values at other times" in what(needs_of(clip, config))) == (not keep)
        frames = [clip.read_frame(index) for index in (0, 11)]
        recipe = recipe_for(config, needs_of(clip, config))
        raw = recipe.initialize(frames)
        model = TrainModel(raw, recipe.make_trainer(raw, frames, 50.0), recipe, 50.0)
        model.step(train_frame(frames[0]), 0)
        first = model.snapshot().motion
        model.step(train_frame(frames[1]), 1)
        last = model.gaussians.motion
        assert isinstance(first, SplineMotion)
        assert isinstance(last, SplineMotion)
        far.append(last.position_controls[:, :4] - first.position_controls[:, :4])
    assert not far[0].any()
    assert far[1].any()


def test_what_moves_can_be_left_out_all_the_same() -> None:
    moving = moving_sheet()
    assert needs_of(moving, SMALL).moves
    assert not needs_of(moving, replace(SMALL, leave_out=("deformation",))).moves
    assert not needs_of(moving, replace(SMALL, leave_out=("color_curves",))).recolors
    with pytest.raises(ValidationError, match="deformation either kept or left out"):
        TrainConfig(keep=("deformation",), leave_out=("deformation",))
    assert TrainConfig(leave_out=("tracks", "poses") * 5) == TrainConfig(leave_out=("poses", "tracks"))


@pytest.mark.parametrize("method", ["deform3dgs", "endogaussian"])
def test_other_methods_rest_on_tissue_at_rest(method: Any) -> None:
    config = replace(SMALL, method=method)
    needs = needs_of(plane_clip(), config)
    assert not needs.moves
    assert isinstance(recipe_for(config, needs).make_trainer(*three_gaussians(config, needs)).motion, Still)
    assert needs_of(plane_clip(circle=3.0), config).sh_degree == 3


def three_gaussians(config: TrainConfig, needs: Needs) -> Any:
    frames = [plane_clip().read_frame(0)]
    return recipe_for(replace(config, n_gaussians=3), needs).initialize(frames), frames, 50.0


def test_what_is_left_out_has_no_numbers() -> None:
    clip = plane_clip(lamp=0.2)
    lit, _ = finished(clip, replace(SMALL, iterations=2))
    assert isinstance(lit.motion, SplineMotion)
    arrays = lit.motion.arrays()
    assert arrays["color_controls"].shape == (len(lit), 6, 3)
    assert not any(value.size for name, value in arrays.items() if name != "color_controls")
    dark, _ = finished(plane_clip(), replace(SMALL, iterations=2))
    assert isinstance(dark.motion, Still)


def test_leaving_out_the_motion_of_resting_tissue_costs_nothing() -> None:
    clip = plane_clip(circle=3.0, lamp=0.2)
    left_out = finished(clip, SMALL)[1]
    assert left_out > 30
    assert left_out > finished(clip, replace(SMALL, keep=("deformation",)))[1] - 0.2


def test_harmonics_show_what_depends_on_the_view() -> None:
    """Light that follows a moving camera, without curves in time."""
    clip = plane_clip(circle=5.0, lamp=0.3)
    config = replace(SMALL, leave_out=("color_curves",), iterations=200)
    model, seen = finished(clip, config)
    assert model.raw.harmonics.shape == (len(model), 15, 3)
    assert seen > finished(clip, replace(config, sh_degree=0))[1] + 3


def test_the_degree_rises_by_one_each_sixth_of_the_run() -> None:
    recipe = recipe_for(SMALL, needs_of(plane_clip(), replace(SMALL, keep=("harmonics",))))
    degrees = [recipe.degree_at(iteration) for iteration in range(SMALL.iterations)]
    assert degrees == [0] * 20 + [1] * 20 + [2] * 20 + [3] * 60


@pytest.mark.parametrize("stop", [15, 45])
def test_a_run_with_harmonics_goes_on_as_if_it_had_never_stopped(tmp_path: Path, stop: int) -> None:
    clip = plane_clip(circle=12.0, lamp=0.3)
    config = replace(SMALL, method="static", iterations=60, checkpoint_every=15)
    whole, _ = finished(clip, config)
    for _ in train(clip, config, folder=tmp_path):
        if len(checkpoint_paths(tmp_path)) and int(checkpoint_paths(tmp_path)[-1].stem[-7:]) >= stop:
            break
    resumed, _ = finished(clip, config, folder=tmp_path, resume=True)
    assert same_bytes(whole, resumed)


@pytest.mark.parametrize("before", [Stillness(0.0, 0.0), Stillness(0.0, 9.0), Stillness(9.0, 9.0)])
def test_a_run_goes_on_as_it_began_whatever_is_measured_by_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: Stillness
) -> None:
    """As where another version finds tissue to move, or to rest."""
    clip = moving_sheet() if before.displacement == 0 else plane_clip()
    config = replace(SMALL, iterations=20, checkpoint_every=5)
    monkeypatch.setattr(deciding, "stillness", lambda frames: before)
    whole, _ = finished(clip, config, folder=tmp_path)
    checkpoint_paths(tmp_path)[-1].unlink()
    monkeypatch.setattr(deciding, "stillness", stillness)
    assert needs_of(clip, config).moves != (before.displacement > 0)
    first, *_, last = train(clip, config, folder=tmp_path, resume=True)
    assert isinstance(first, Started)
    assert isinstance(last, Finished)
    assert first.iteration == 15
    assert same_bytes(whole, last.model)
    why = {each.what: each.why for each in first.omitted}
    assert why.get("deformation", "").endswith("the run began without") == (before.displacement == 0)


def test_unseen_gaussians_change_no_tissue_in_any_frame() -> None:
    """Four Gaussians are put where no frame looks: beside the view, behind it, under the mask, invisible."""
    clip = plane_clip(masked=True)
    model, _ = finished(clip, replace(SMALL, iterations=2))
    raw = model.raw.rows(np.array([0, 1, 2, 3, *range(len(model))]))
    raw.means[:4] = (500, 0, 50), (0, 0, -50), (-24.5, -20, 50), (0, 0, 50)
    raw.log_scales[:4] = -1
    raw.opacity_logits[3] = -20
    frames = [train_frame(clip.read_frame(index)) for index in range(3)]
    more = DynamicGaussians(raw, Still())
    assert not seen_in(more, frames, 0.05)[:4].any()
    fewer, (omission,) = without_unseen(more, frames, 0.05)
    assert len(fewer) == seen_in(more, frames, 0.05).sum()
    assert omission.saves == f"{len(more) - len(fewer)} of {len(more)} Gaussians"
    for frame in frames:
        tissue = frame.tile_wanted.repeat(16, 0).repeat(16, 1)[:80, :96]
        pictures = [render(each.at(frame.time), frame.camera, near=0.05).image for each in (more, fewer)]
        assert np.array_equal(pictures[0][tissue], pictures[1][tissue])
        assert tissue.any()
    assert without_unseen(fewer, frames, 0.05) == (fewer, ())


def test_a_run_drops_what_it_never_saw_unless_it_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Five Gaussians go astray before the first step."""
    clip = plane_clip()
    few = replace(SMALL, iterations=2, n_gaussians=60)

    def astray(config: TrainConfig, needs: Needs) -> Recipe:
        recipe = recipe_for(config, needs)

        def initialize(frames: Sequence[Frame]) -> RawGaussians:
            raw = recipe.initialize(frames)
            raw.means[:5, 2] *= -1
            return raw

        return replace(recipe, initialize=initialize)

    monkeypatch.setattr(trainer, "recipe_for", astray)
    *_, last = train(clip, few)
    *_, kept = train(clip, replace(few, keep=("unseen",)))
    assert isinstance(last, Finished)
    assert isinstance(kept, Finished)
    assert (len(last.model), len(kept.model)) == (55, 60)
    assert [omission.saves for omission in last.omitted] == ["5 of 60 Gaussians"]
    assert kept.omitted == ()
    assert np.array_equal(last.model.means, kept.model.means[5:])


def test_tiles_without_tissue_make_no_difference_to_a_step() -> None:
    clip = plane_clip(masked=True)
    frames = [clip.read_frame(index) for index in (0, 2)]
    values = []
    for keep in ((), ("tiles",)):
        config = replace(SMALL, keep=keep)
        recipe = recipe_for(config, needs_of(clip, config))
        raw = recipe.initialize(frames)
        model = TrainModel(raw, recipe.make_trainer(raw, frames, 50.0), recipe, 50.0)
        losses = [model.step(train_frame(frame), iteration).loss for iteration, frame in enumerate(frames)]
        values.append((losses, model.raw.means))
    assert values[0][0] == values[1][0]
    assert np.array_equal(values[0][1], values[1][1])


def test_halving_without_masks_is_the_same_but_for_rounding() -> None:
    frame = train_frame(plane_clip().read_frame(2))
    one, other = halved(frame, has_masks=True), halved(frame, has_masks=False)
    assert np.abs(one.colors.astype(int) - other.colors).max() <= 1
    assert np.array_equal(one.color_mask, other.color_mask)
    assert np.array_equal(one.depth, other.depth)
