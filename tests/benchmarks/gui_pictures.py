"""A picture of every panel and dialog of the window, to be looked at.

xvfb-run -a -s "-screen 0 3840x2160x24" python -m tests.benchmarks.gui_pictures RUN OUT
    [--size 1280x720] [--theme dark] [--density 1] [--text 100] [--only NAME]

RUN is a finished reconstruction of the built-in phantom. `--density 2`: a screen of twice as many pixels.
"""

from __future__ import annotations

import argparse
import random
import re
import shutil
import tempfile
from pathlib import Path
from typing import get_args

from imgui_bundle.immapp import testing

from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import TEXT_PERCENTS, Places, Settings, Theme
from assets import phantom_path
from tests.app.gui.conftest import FakeJob
from tests.benchmarks.person import UNPACED, Context, Person, quieten
from tests.benchmarks.picture_scenes import SCENES, Model


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("run", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--theme", choices=get_args(Theme), default="dark")
    parser.add_argument("--density", type=int, default=1)
    parser.add_argument("--text", type=int, choices=TEXT_PERCENTS, default=100)
    parser.add_argument("--only", default="", help="scenes whose names match this expression")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    settings = Settings(
        theme=given.theme, text_percent=given.text, recent=(str(phantom_path()), "/x/pulling")
    )
    width, height = map(int, given.size.split("x"))
    with tempfile.TemporaryDirectory() as folder:
        window = window_in(Path(folder), settings)
        params = window.runner_params()
        params.ini_disable = True
        params.app_window_params.window_geometry.size = (width, height)
        params.dpi_aware_params.dpi_window_size_factor = float(given.density)

        def drive(ctx: Context) -> None:
            quieten(ctx)
            run = Path(shutil.copytree(given.run, window.state.places.runs / given.run.name))
            person = Person(ctx, window, phantom_path(), random.Random(0), UNPACED, run=run)
            _take(person, given.out, re.compile(given.only))

        testing.run(test_function=drive, runner_params=params, add_ons_params=window.add_ons())


def window_in(folder: Path, settings: Settings) -> Window:
    """Of a user without anything yet."""
    places = Places(folder / "config", folder / "runs", folder / "pictures")
    for path in (places.config, places.runs, places.pictures):
        path.mkdir()
    return Window(AppState(places, settings), FakeJob)


def _take(person: Person, out: Path, wanted: re.Pattern[str]) -> None:
    """Every scene in turn: each is left as the next one finds it."""
    model = Model.of_run(person.run) if person.run is not None else None
    assert model is not None
    for place, scene in enumerate(SCENES):
        for name in scene(person, model):
            person.ctx.yield_(4)
            if wanted.search(name):
                testing.capture(person.ctx, str(out / f"{place:02d}-{name}.png"))


if __name__ == "__main__":
    main()
