"""What is said of the methods and their defaults, where figures are told."""

from __future__ import annotations

import re
from dataclasses import fields
from typing import get_args

import pytest

from renderer.train.config import CHOSEN, Method, TrainConfig
from renderer.train.methods import departures


def test_the_departures_of_each_method_can_be_told() -> None:
    for method in get_args(Method):
        assert departures(method).startswith(f"`{method}`")


@pytest.mark.parametrize("method", ["deform3dgs", "endogaussian"])
def test_how_depth_is_supervised_otherwise_than_published_is_stated(method: Method) -> None:
    said = " ".join(departures(method).split())
    assert "clipped to its 3rd to 99.8th percentile" in said
    assert "unknown depth (0)" in said


def test_one_schedule_over_rest_and_motion_is_stated() -> None:
    said = " ".join(departures("endogaussian").split())
    assert "one schedule of rates over the steps at rest and those with motion" in said


def test_only_three_defaults_are_said_to_be_chosen_on_frames_held_out() -> None:
    held_out, others = CHOSEN.split("held out")
    named = {item.name for item in fields(TrainConfig)} & {*re.findall(r"\w+", held_out)}
    assert named == {"depth_weight", "color_motion_rate", "scale_rate"}
    assert "test frames in view" in others
    assert "hold_out" not in (TrainConfig.__doc__ or "")
