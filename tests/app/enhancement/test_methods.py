"""What files hold of the settings of two methods is read as that method's."""

from __future__ import annotations

import pytest
from pydantic import TypeAdapter

from app.enhancement.methods import RecordedSettings
from enhance import EnhanceParams, VesselParams


@pytest.mark.parametrize(
    ("told", "kind"),
    [
        ({}, EnhanceParams),
        ({"d_factor": 0.5}, EnhanceParams),
        ({"strength": 0.5, "z": None}, EnhanceParams),
        ({"strength": 3.0}, VesselParams),
        ({"strength": 3.0, "d_factor": 0.5}, VesselParams),
        ({"lift": 0.2}, VesselParams),
    ],
)
def test_what_a_file_holds_says_of_which_method_it_is(told: dict[str, object], kind: type[object]) -> None:
    assert isinstance(TypeAdapter(RecordedSettings).validate_python(told), kind)
