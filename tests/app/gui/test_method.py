"""The two methods of enhancement in the window: what is chosen is what is seen, said and saved."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from app.enhancement.frame_enhancer import PictureMaker, PictureRequest, Pictures
from app.enhancement.setting_words import VESSEL_LABELS
from app.files.provenance import read_provenance
from app.gui.actions import enhancement_actions, history_actions, job_actions
from app.gui.panels.enhancement import draw_enhancement
from app.gui.panels.enhancement_measured import UNUSED, facts_of
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from app.gui.update.jobs import start_due
from app.runs.train_run import TrainRequest
from enhance import EnhanceParams, measure
from enhance.vessel import VesselParams, enhance_vessels
from renderer.clip import Clip
from tests.app.gui.conftest import FakeJob, image_of
from tests.app.gui.saving import saved
from tests.app.gui.ui import Shown, Ui

STRONG = VesselParams(strength=3.0)


def made(request: PictureRequest) -> Pictures:
    return list(PictureMaker().make(request))[-1]


def test_the_preset_s_picture_is_the_library_s(clip: Clip) -> None:
    shown = made(PictureRequest(clip, 2, STRONG))
    np.testing.assert_array_equal(shown.enhanced, enhance_vessels(image_of(2), STRONG).image)
    pooled = made(PictureRequest(clip, 2, STRONG, "clip"))
    statistics = measure(map(image_of, range(len(clip))))
    wanted = enhance_vessels(image_of(2), STRONG, statistics=statistics)
    np.testing.assert_array_equal(pooled.enhanced, wanted.image)


def test_each_method_keeps_its_parameters_and_undo_goes_between_them(state: AppState) -> None:
    enhancement_actions.set_params(state, EnhanceParams(z=0.3))
    enhancement_actions.choose_method(state, VesselParams)
    assert state.enhancement.params == VesselParams()
    enhancement_actions.settle_params(state)
    enhancement_actions.set_params(state, STRONG)
    enhancement_actions.choose_method(state, EnhanceParams)
    assert state.enhancement.params == EnhanceParams(z=0.3)
    enhancement_actions.choose_method(state, VesselParams)
    assert state.enhancement.params == STRONG
    for wanted in (EnhanceParams(z=0.3), STRONG, VesselParams(), EnhanceParams(z=0.3), EnhanceParams()):
        history_actions.undo(state)
        assert state.enhancement.params == wanted
    enhancement_actions.set_params(state, STRONG)
    enhancement_actions.reset_params(state)
    assert state.enhancement.params == VesselParams()


def test_a_reconstruction_takes_the_image_s_method(state: AppState) -> None:
    enhancement_actions.set_params(state, EnhanceParams(z=0.3))
    enhancement_actions.choose_method(state, VesselParams)
    job_actions.start_reconstruction(state)
    start_due(state, FakeJob)
    request = state.runs.reconstruction.request
    assert isinstance(request, TrainRequest)
    assert request.enhance_params == VesselParams()


def test_every_parameter_of_the_preset_has_its_slider(ui: Ui, state: AppState) -> None:
    assert {*VESSEL_LABELS, "strength"} == {field.name for field in fields(VesselParams)}
    enhancement_actions.choose_method(state, VesselParams)
    for _ in range(2):
        ui.frame(lambda: draw_enhancement(state, Shown()))
    assert state.enhancement.params == VesselParams()


def test_the_picture_and_the_file_say_which_method(tmp_path: Path, state: AppState, clip: Clip) -> None:
    clip.path.mkdir()
    for params, method in ((STRONG, "vessel"), (replace(EnhanceParams(), z=0.3), "paper")):
        state.enhancement.params = params
        shown = made(PictureRequest(clip, 2, params))
        words = " ".join(tag.text for tag in pane(state, shown, "right").tags)
        assert words.startswith("ENHANCED Vessel ") == (method == "vessel")
        pane_facts = read_provenance(saved(tmp_path / "out", shown.request))["panes"][1]
        assert type(params)(**pane_facts["params"]) == params


def test_what_was_not_measured_is_said_to_be_unused(clip: Clip) -> None:
    for params, unused in ((EnhanceParams(), []), (EnhanceParams(p=0.8), ["σ"]), (STRONG, ["σ"])):
        shown = made(PictureRequest(clip, 2, params))
        assert shown.statistics is not None
        facts = {name: value for name, value, _ in facts_of(shown.statistics, 1.0)}
        assert all(facts.values())
        assert [name for name, value in facts.items() if value == UNUSED] == unused
