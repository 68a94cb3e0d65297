from __future__ import annotations

import pytest
from pydantic import TypeAdapter, ValidationError

from enhance import EnhanceParams


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("z", -0.01),
        ("z", float("nan")),
        ("p", 4.1),
        ("p", (0.5, 0.5)),
        ("p_form", "smooth"),
        ("radii", ()),
        ("radii", (0,)),
        ("radii", (513,)),
        ("radii", (4.5,)),
        ("radii", (1,) * 7),
        ("eps", 0.0),
        ("eps", float("inf")),
        ("subsample", 9),
        ("d_factor", -1.0),
        ("strength", 2.1),
        ("lift", 1.0),
    ],
)
def test_a_value_out_of_range_is_refused_by_name(name: str, value: object) -> None:
    with pytest.raises(ValidationError, match=name):
        EnhanceParams(**{name: value})  # type: ignore[arg-type]


def test_parameters_survive_json() -> None:
    adapter = TypeAdapter(EnhanceParams)
    params = EnhanceParams(z=0.3, p=(0.5, 1.0, 1.75), radii=(3, 9, 27), keep_black=False)
    assert adapter.validate_json(adapter.dump_json(params)) == params
    assert adapter.validate_json(adapter.dump_json(EnhanceParams())) == EnhanceParams()


def test_every_parameter_says_what_it_does() -> None:
    properties = TypeAdapter(EnhanceParams).json_schema()["properties"]
    assert properties.keys() == EnhanceParams.__dataclass_fields__.keys()
    assert all(len(entry["description"]) > 20 for entry in properties.values())
