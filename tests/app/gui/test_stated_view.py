"""A field of view that a person states is kept as stated; former files name one that nobody has stated."""

from __future__ import annotations

import json

from app.gui.session_file import Session, mended_session, write_session
from app.gui.work.settings import FILE, KnownClip, Places, clips_content, load_clips
from renderer.readers.clip_options import ClipOptions


def test_of_clips_that_are_known(places: Places) -> None:
    places.config.mkdir(parents=True)
    former = {"a": {"trim": [0, 3], "field_of_view": 60.0}, "b": {"field_of_view": 80.0}}
    (places.config / FILE).write_text(json.dumps(former))
    there = load_clips(places.config)
    assert there["a"] == KnownClip(trim=(0, 3))
    assert there["b"].view_angle == 80
    (places.config / FILE).write_bytes(clips_content({"c": KnownClip(view_angle=60)}))
    assert load_clips(places.config)["c"].view_angle == 60


def test_of_sessions(places: Places) -> None:
    path = places.pictures / "d.vesselsplat"
    path.parent.mkdir(parents=True)
    write_session(path, Session(notes="one", clip_options=ClipOptions(field_of_view=60)))
    content = path.read_text()
    assert json.loads(content)["clip_options"]["field_of_view"] == 60
    former = json.loads(content) | {"version": "0.1", "source": {"path": "clip"}}
    path.write_text(json.dumps(former))
    assert mended_session(path)[0].clip_options == ClipOptions()


def test_stated_or_assumed_it_reads_the_same() -> None:
    assert ClipOptions(field_of_view=60).reads_as(ClipOptions())
    assert not ClipOptions(field_of_view=61).reads_as(ClipOptions())
    assert not ClipOptions(field_of_view=60, depth="off").reads_as(ClipOptions())
