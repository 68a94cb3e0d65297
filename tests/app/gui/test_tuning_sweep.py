"""The tuning grid saved as a sweep: what the command runs is what the window would try."""

from __future__ import annotations

import shlex
from dataclasses import replace

import pytest

from app.enhancement.methods import EnhancementSettings
from app.files.provenance import write_png
from app.gui.actions import enhancement_actions, tuning_actions
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.work.writing import WriteRequest, write_file
from app.sweeps.settings import Enhancing
from app.sweeps.spec import all_settings, read_spec
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, LensCalibration
from tests.app.conftest import Cli

CHOICES = {
    EnhanceParams: (Choice("d_factor", 0.0, 2.0, 3), Choice("subsample", 1, 2, 2)),
    VesselParams: (Choice("strength", 0.5, 1.0, 2), Choice()),
}


@pytest.mark.parametrize(
    "look", [EnhanceParams(z=0.3, radii=(2, 8)), VesselParams()], ids=["paper", "vessel"]
)
def test_the_saved_sweep_runs_with_the_values_of_the_grid(
    state: AppState, look: EnhancementSettings, vesselsplat: Cli
) -> None:
    assert state.source.clip is not None
    write_png(state.source.clip.path / "0.png", state.source.clip.read_image(0), {})
    state.settings = replace(state.settings, folders={"export": str(state.places.pictures / 'of "A" $B')})
    enhancement_actions.set_params(state, look)
    state.enhancement.scope = "clip"
    state.source.options = ClipOptions(stereo="off", deinterlacing="field")
    state.tuning.choices = CHOICES[type(look)]
    tuning_actions.save_sweep(state)
    (request,) = (wish for wish in state.window.wishes if isinstance(wish, WriteRequest))
    (path,) = write_file(request)
    out = path.with_suffix("")
    assert shlex.split(state.window.log[-1]) == ["vesselsplat", "sweep", str(path), "--out", str(out)]
    tuning_actions.start_grid(state)
    assert state.tuning.grid is not None
    asked = all_settings(read_spec(path))
    assert {(one.statistics, one.options) for one in asked if isinstance(one, Enhancing)} == {
        ("clip", state.source.options)
    }
    assert {one.params for one in asked if isinstance(one, Enhancing)} == {
        setting.params for setting in state.tuning.grid.settings
    }
    dry = vesselsplat("sweep", path, "--out", out, "--dry-run")
    assert (dry.code, dry.error) == (0, "")
    assert f"{len(state.tuning.grid.settings)} jobs on 1 clip" in dry.out


def test_what_a_sweep_has_no_room_for_is_told(state: AppState) -> None:
    state.tuning.choices = CHOICES[EnhanceParams]
    enhancement_actions.set_params(state, EnhanceParams())
    state.source.part = replace(state.source.part, trim=(1, 2))
    state.source.options = ClipOptions(
        calibration=Calibration(lens=LensCalibration(fx=50, fy=50, cx=32, cy=24))
    )
    tuning_actions.save_sweep(state)
    told = "does not hold the range of frames and the calibration of the lens"
    assert told in state.window.log[-2]


def test_nothing_to_vary_is_said_and_nothing_is_written(state: AppState) -> None:
    state.tuning.choices = (Choice(), Choice())
    tuning_actions.save_sweep(state)
    assert not state.window.wishes
    assert state.window.banner is not None
