"""A window with a session in it that waits to be killed: python -m tests.app.gui.kept_session FOLDER."""

from __future__ import annotations

import sys
from pathlib import Path

from imgui_bundle import imgui

from app.gui.actions import actions
from app.gui.session_file import autosave_path, mended_session
from app.gui.work.settings import Places
from assets import phantom_path
from enhance import EnhanceParams
from tests.app.gui.driver import Driver, is_settled, wait


def places_in(root: Path) -> Places:
    return Places(root / "config", root / "runs", root / "pictures")


def main(root: Path) -> None:
    driver = Driver(places_in(root), opens=phantom_path())
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state), "the phantom")
        ctx.item_input_value("//Enhancement/**/##d_factor", 0.4)
        actions.seek(state, 7)
        state.session.notes, state.enhancement.scope = "left ureter?", "clip"
        kept = autosave_path(state.places.config)
        wait(
            ctx, lambda: kept.exists() and mended_session(kept)[0].notes != "", "the session saved in passing"
        )
        wait(ctx, lambda: mended_session(kept)[0].params == EnhanceParams(d_factor=1.5), "all of it")
        sys.stdout.write("kept\n")
        sys.stdout.flush()
        while True:
            ctx.yield_()

    driver.run(drive)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
