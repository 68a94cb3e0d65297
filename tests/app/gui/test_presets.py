"""Settings by name, kept between sessions; a damaged file loses nothing and is told."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from app.gui.actions import enhancement_actions, history_actions, preset_actions
from app.gui.state.app_state import AppState
from app.gui.work.presets import (
    BUILT_IN,
    load_presets,
    merged_presets,
    preset_name,
    presets_file,
    save_presets,
)
from app.runs.train_run import RECONSTRUCTION_PARAMS
from enhance import EnhanceParams, enhance_vessels, vessel_contrast
from enhance.vessel import VesselParams
from renderer.clip import ByteImage
from renderer.phantom import Phantom, PhantomParams
from tests.app.gui.settling import keep_all

OWN = {"mine": EnhanceParams(z=0.25, p=(0.5, 1.0, 1.5)), "ours, stronger": VesselParams(strength=3.5)}


def test_own_presets_come_back_as_they_were(tmp_path: Path) -> None:
    path = tmp_path / "presets.json"
    assert load_presets(path) == ({}, "")
    save_presets(path, OWN)
    assert load_presets(path) == (OWN, "")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"mine": {"z": 7}}', '{"mine": 3}', '{"a": {"strength": -1}}']
)
def test_a_damaged_file_is_told_and_put_aside(tmp_path: Path, text: str) -> None:
    path = tmp_path / "presets.json"
    path.write_text(text)
    presets, trouble = load_presets(path)
    assert presets == {}
    assert "presets.damaged.json" in trouble
    save_presets(path, OWN)
    assert (tmp_path / "presets.damaged.json").read_text() == text
    assert load_presets(path) == (OWN, "")


def test_one_of_a_reserved_name_gets_a_free_one(tmp_path: Path) -> None:
    path, looks = tmp_path / "presets.json", [VesselParams(strength=strength) for strength in (3.0, 1.5, 2.0)]
    save_presets(path, dict(zip(("Gentle", "Gentle (own)", "Paper"), looks, strict=True)))
    names = ("Gentle (own) 2", "Gentle (own)", "Paper (own)")
    found, trouble = load_presets(path)
    assert (found, trouble) == (dict(zip(names, looks, strict=True)), "")
    assert merged_presets(path, found, found) == found


def test_gentle_lies_between_the_original_and_vessels() -> None:
    view = Phantom(PhantomParams(n_frames=1, width=320, height=256)).view(0)
    original, vessels = view.frame.image, view.vessel_mask
    shown = [original] + [enhanced(original, name) for name in ("Gentle", "Vessels")]
    for measure in (brightness, color, partial(vessel_contrast, vessel_mask=vessels)):
        least, middle, most = map(measure, shown)
        assert 0.2 < (middle - least) / (most - least) < 0.8, measure


def enhanced(image: ByteImage, name: str) -> ByteImage:
    params = BUILT_IN[name]
    assert isinstance(params, VesselParams)
    return np.asarray(enhance_vessels(image, params).image, np.uint8)


def brightness(image: ByteImage) -> float:
    return float(image.max(-1).mean())


def color(image: ByteImage) -> float:
    most = image.max(-1).astype(float)
    return float((1 - image.min(-1) / np.maximum(most, 1)).mean())


def test_the_built_in_ones_are_the_paper_s_and_ours() -> None:
    assert preset_name(VesselParams(), {}) == "Vessels"
    assert preset_name(EnhanceParams(), {}) == "Paper"
    assert preset_name(EnhanceParams(d_factor=1.0), OWN) == "Paper, colour 0.50"
    assert preset_name(RECONSTRUCTION_PARAMS, OWN) == "Paper, colour 0.67 (3D)"
    assert len(set(BUILT_IN.values())) == len(BUILT_IN)
    assert preset_name(OWN["mine"], OWN) == "mine"
    assert preset_name(EnhanceParams(z=0.9), OWN) == "Custom"


def test_a_name_that_is_there_is_told_before_it_is_replaced(state: AppState) -> None:
    preset_actions.type_name(state, " mine ")
    assert not preset_actions.replaced(state)
    preset_actions.keep(state, "mine")
    keep_all(state)
    assert preset_actions.replaced(state) == "mine"
    preset_actions.keep(state, "mine")
    keep_all(state)
    assert state.window.log[-1] == "preset mine replaced"


def test_keeping_choosing_and_forgetting(state: AppState) -> None:
    enhancement_actions.set_params(state, OWN["mine"])
    preset_actions.keep(state, "  mine ")
    keep_all(state)
    enhancement_actions.set_params(state, EnhanceParams(z=0.9))
    preset_actions.choose(state, "mine")
    assert state.enhancement.params == OWN["mine"]
    history_actions.undo(state)
    assert state.enhancement.params == EnhanceParams(z=0.9)
    assert load_presets(presets_file(state.places))[0] == {"mine": OWN["mine"]}
    preset_actions.choose(state, "no such preset")
    assert state.enhancement.params == EnhanceParams(z=0.9)
    for delete in (False, True):
        assert "mine" in state.enhancement.presets
        preset_actions.ask_forget(state, "mine")
        preset_actions.answer_forget(state, delete=delete)
        keep_all(state)
    assert load_presets(presets_file(state.places))[0] == state.enhancement.presets == {}


def test_an_own_preset_is_renamed_but_takes_no_other_ones_place(state: AppState) -> None:
    for name, z in (("mine", 0.3), ("yours", 0.6)):
        enhancement_actions.set_params(state, EnhanceParams(z=z))
        preset_actions.keep(state, name)
        keep_all(state)
    for typed in ("yours", "Paper", " "):
        preset_actions.ask_rename(state, "mine")
        preset_actions.type_name(state, typed)
        assert preset_actions.why_not_rename(state)
        preset_actions.answer_rename(state, rename=True)
        keep_all(state)
        assert set(state.enhancement.presets) == {"mine", "yours"}
    for rename, names in ((False, {"mine", "yours"}), (True, {"Mine, darker", "yours"})):
        preset_actions.ask_rename(state, "mine")
        assert not preset_actions.why_not_rename(state)
        preset_actions.type_name(state, " Mine, darker ")
        preset_actions.answer_rename(state, rename=rename)
        keep_all(state)
        assert load_presets(presets_file(state.places))[0] == state.enhancement.presets
        assert set(state.enhancement.presets) == names
    assert state.enhancement.presets["Mine, darker"] == EnhanceParams(z=0.3)
    assert state.window.log[-1] == "preset mine renamed to Mine, darker"


@pytest.mark.parametrize("name", ["", "   ", "Custom", *BUILT_IN])
def test_a_name_that_is_taken_or_empty_is_refused(state: AppState, name: str) -> None:
    preset_actions.keep(state, name)
    assert state.window.banner is not None
    assert not state.enhancement.presets


def test_what_cannot_be_written_is_told_and_changes_nothing(state: AppState) -> None:
    state.places.config.parent.mkdir(parents=True, exist_ok=True)
    state.places.config.write_text("a file where the folder should be")
    preset_actions.keep(state, "mine")
    keep_all(state)
    assert state.window.banner is not None
    assert "cannot be saved" in state.window.banner.message
    assert not state.enhancement.presets


def test_two_windows_keep_each_other_s_presets(state: AppState) -> None:
    other = AppState(state.places)
    preset_actions.keep(state, "mine")
    keep_all(state)
    preset_actions.keep(other, "theirs")
    keep_all(other)
    assert set(state.enhancement.presets) | {"theirs"} == set(other.enhancement.presets) == {"mine", "theirs"}
    # What one forgets does not come back by the other, which never heard of it.
    preset_actions.forget(other, "mine")
    keep_all(other)
    preset_actions.keep(state, "third")
    keep_all(state)
    found, _ = load_presets(presets_file(state.places))
    assert set(found) == set(state.enhancement.presets) == {"theirs", "third"}


def test_the_later_change_of_one_name_counts(tmp_path: Path) -> None:
    path, one, two = tmp_path / "presets.json", EnhanceParams(z=0.3), EnhanceParams(z=0.6)
    save_presets(path, {"a": one, "b": one})
    assert merged_presets(path, {"a": two, "b": one}, {"a": one, "b": one}) == {"a": two, "b": one}
    save_presets(path, {"a": two, "c": two})
    assert merged_presets(path, {"a": one, "b": two}, {"a": one, "b": one}) == {"a": two, "b": two, "c": two}
    assert merged_presets(path, {}, {"a": one, "b": one}) == {"c": two}
