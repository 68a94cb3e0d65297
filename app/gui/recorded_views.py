"""Named views and a camera path as a field of what the app keeps as JSON."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator

from renderer.json_files import parsed
from renderer.view_files import Views, views_json, views_of


def _facts(views: Views) -> Any:
    return parsed(views_json(views))


def _views(given: Any) -> Views:
    return given if isinstance(given, Views) else views_of(given)


RecordedViews = Annotated[Views, PlainValidator(_views), PlainSerializer(_facts)]
