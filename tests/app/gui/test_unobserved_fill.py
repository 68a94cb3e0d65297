"""A smooth fill, where nothing was observed, is never left to pass for tissue."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.actions import actions, comparing
from app.gui.state.panes import pane
from app.gui.state.tags import cautions
from app.gui.state.view_words import view_tags
from app.gui.work.settings import Places
from app.scenes.backgrounds import BackgroundName
from tests.app.gui.exporting import Exporter
from tests.app.gui.ui import texts


@pytest.mark.parametrize(("name", "said"), [("smooth", True), ("hatched", False), ("grey", False)])
def test_a_fill_that_could_pass_for_tissue_is_said_to_be_none(
    places: Places, runs: dict[str, Path], name: BackgroundName, said: bool
) -> None:
    """In the view and in a pane; a map of depth has no such fill."""
    run = Exporter(places, runs["original"])
    actions.choose_background(run.state, name)
    comparing.choose_source(run.state, "left", "render")
    run.turn(6)
    shown, pictures = run.state.view_request, run.state.picture.pictures
    assert shown is not None
    assert pictures is not None
    tags = view_tags(run.state, shown), pane(run.state, pictures, "left").tags
    assert ["not observed" in texts(cautions(each)) for each in tags] == [said, said]
    assert "not observed" not in texts(view_tags(run.state, replace(shown, kind="depth")))
