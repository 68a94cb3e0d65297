"""The window with the settings of a folder, for a few frames.

`python -m tests.benchmarks.attack.window_start FOLDER`: the exit code says how it ended.
"""

from __future__ import annotations

import faulthandler
import sys
from pathlib import Path

from app.__main__ import keep_quiet
from app.gui.actions import recovering
from app.gui.state.app_state import AppState
from app.gui.window import Window
from app.gui.work.settings import Places, load_settings

FRAMES = 12


def main() -> None:
    """See the module."""
    faulthandler.enable()
    keep_quiet()
    folder = Path(sys.argv[1])
    places = Places(folder, folder / "runs", folder / "pictures")
    window = Window(AppState(places, load_settings(places.settings_file)))
    recovering.offer_recovery(window.state)
    params = window.runner_params()
    frames = iter(range(FRAMES))

    def after_frame() -> None:
        params.app_shall_exit = next(frames, None) is None

    params.callbacks.before_swap = after_frame
    window.runner_params = lambda: params  # type: ignore[method-assign]
    window.run()


if __name__ == "__main__":
    main()
