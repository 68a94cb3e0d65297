"""The page to print: it holds the images as they are, says what they are, and comes again."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.exports.exporting import ExportRequest, Summary, export
from app.exports.html_file import facts_in
from app.exports.make import make
from app.exports.records import EXPORT, CaseSummary, PanesPicture
from app.exports.replay.again import replay
from app.exports.sources import Opened
from app.exports.summary.page import summary_page
from app.exports.summary.saved_picture import read_picture
from app.files.provenance import NOTICE, provenance, write_png
from app.files.stepping import run_to_end
from app.runs.clip_selection import ClipPart
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.scene import Scene, open_scene
from app.scenes.view_request import ViewRequest, view_record
from tests.app.conftest import Cli

BEFORE = Path(__file__).with_name("before")
NAMES = ("panes.png", "render-color.png", "enhanced.png", "tuning-sheet.png")
PICTURES = tuple(BEFORE / name for name in NAMES)


def page_of(path: Path, *pictures: tuple[Path, str], title: str = "A case", notes: str = "") -> str:
    wanted = Summary(title, "2026-01-31", notes, pictures)
    run_to_end(make(wanted.record(), Opened(files=wanted.files), path))
    return path.read_text()


def test_it_holds_every_image_byte_by_byte_each_with_the_notice(tmp_path: Path) -> None:
    page = page_of(tmp_path / "page.html", *((path, "") for path in PICTURES))
    held = [base64.b64decode(text) for text in re.findall(r'src="data:image/png;base64,([^"]+)"', page)]
    assert held == [path.read_bytes() for path in PICTURES]
    assert page.count(f"<figcaption>{NOTICE}</figcaption>") == len(PICTURES)
    assert "http" not in re.sub(r"base64,[^\"]+", "", page), "nothing comes over a network"


def test_it_says_what_is_in_each(tmp_path: Path) -> None:
    page = page_of(tmp_path / "page.html", *((path, f"note {path.stem}") for path in PICTURES))
    heads = re.findall(r"<h2>(.*?)</h2>", page)
    assert heads == ["1. clip, frame 4", "2. run, frame 4", "3. frame-000002.color.png", "4. photo.png"]
    assert re.findall(r'<p class="note">(.*?)</p>', page) == [f"note {path.stem}" for path in PICTURES]
    assert "<td>Enhanced</td><td>Brightness auto 0.29" in page
    assert "from frames enhanced by Brightness" in page


def test_a_tuned_image_tells_its_measures(tmp_path: Path) -> None:
    picture, page = tmp_path / "tuned.png", tmp_path / "page.html"
    picture.write_bytes((BEFORE / "tuned.png").read_bytes())
    text = page_of(page, (picture, ""))
    assert re.findall(r'<th class="number">(.*?)</th>', text) == ["Noise gain", "DV/BV*"]
    assert re.findall(r'<td class="number">(.*?)</td>', text) == ["1.30", "1.52"]
    assert replay(page, (), tmp_path / "again.html").difference.is_none
    facts = {name: value for name, value in facts_in(text).items() if name != "measures_of"}
    run_to_end(make(EXPORT.validate_python(facts), Opened(files=(picture,)), page))
    assert "Noise gain" not in page.read_text(), "as before 0.4.0"


def test_what_is_typed_is_text_and_nothing_else(tmp_path: Path) -> None:
    typed = '</p></script><script>alert("&")</script>'
    page = page_of(tmp_path / "page.html", (PICTURES[0], typed), title=typed[:90], notes=typed)
    assert "<script>alert" not in page
    assert unescape(re.findall(r'<p class="note">(.*?)</p>', page)[0]) == typed
    facts = facts_in(page)
    assert (facts["title"], facts["notes"], facts["pictures"][0]["note"]) == (typed[:90], typed, typed)


def test_the_page_comes_again_and_not_of_other_images(tmp_path: Path) -> None:
    copies = [tmp_path / name for name in NAMES]
    for copy, path in zip(copies, PICTURES, strict=True):
        copy.write_bytes(path.read_bytes())
    page = tmp_path / "page.html"
    page_of(page, *((path, "") for path in copies))
    assert replay(page, (), tmp_path / "again.html").difference.is_none
    copies[1].write_bytes(PICTURES[2].read_bytes())
    with pytest.raises(Exception, match=r"has changed since page\.html was made"):
        replay(page, (), tmp_path / "other.html")
    assert not (tmp_path / "other.html").exists()


def test_an_image_of_a_kind_that_is_not_known_is_shown_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "next.png"
    write_png(path, np.zeros((4, 5, 3), np.uint8), provenance(kind="hologram", source={"name": "a.mp4"}))
    found = read_picture(path)
    assert (found.title, [part.shows for part in found.parts]) == ("a.mp4", ["Hologram"])


def title_of_view(scene: Scene, frame: int, path: Path) -> str:
    """Of a picture of the 3D view alone, as the window saves it."""
    view = view_record(ViewRequest.of_frame(scene, frame), ON_CPU)
    write_png(path, np.zeros((4, 5, 3), np.uint8), PanesPicture(views=(view,)).signed)
    return read_picture(path).title


def test_a_3d_view_alone_is_headed_by_its_own_frame(tmp_path: Path) -> None:
    scene = open_scene(BEFORE / "run")
    assert [title_of_view(scene, frame, tmp_path / "a.png") for frame in (0, 4)] == [
        "run, frame 1",
        "run, frame 5",
    ]


def test_a_3d_view_of_a_part_is_headed_by_the_frame_of_the_clip(tmp_path: Path) -> None:
    path, scene = tmp_path / "a.png", replace(open_scene(BEFORE / "run"), first=100)
    assert title_of_view(scene, 4, path) == "run, frame 105"


@pytest.mark.parametrize(("window", "title"), [(None, "run, frame 105"), (2, "run")])
def test_an_image_that_tells_no_start_is_headed_by_what_it_tells_of_the_clip(
    window: int | None, title: str, tmp_path: Path
) -> None:
    """As earlier versions saved them."""
    scene = open_scene(BEFORE / "run")
    assert scene.record.clip is not None
    clip = replace(scene.record.clip, part=ClipPart(trim=(100, 105)))
    record = replace(scene.record, clip=clip, window=window)
    assert title_of_view(replace(scene, record=record), 4, tmp_path / "a.png") == title


def test_a_record_of_the_page_is_read_back(tmp_path: Path) -> None:
    page_of(tmp_path / "page.html", (PICTURES[0], "a\nb"), notes="c")
    facts: dict[str, Any] = facts_in((tmp_path / "page.html").read_text())
    told = CaseSummary(**{name: facts[name] for name in ("title", "day", "notes", "pictures")})
    assert (told.notes, told.pictures[0].note, told.pictures[0].picture.name) == ("c", "a\nb", "panes.png")


def test_a_page_fits_phones_and_paper_and_one_that_does_not_say_so_comes_again_as_it_was() -> None:
    told = Summary("A case", "2026-01-31", "", ((PICTURES[0], ""),)).record()
    pictures = [read_picture(PICTURES[0])]
    fitted, before = (summary_page(one, pictures).decode() for one in (told, replace(told, layout=None)))
    for rule in ("min-width: min(20rem, 100%)", "object-fit: contain", "overflow-x: auto"):
        assert rule in fitted
        assert rule not in before


def test_the_command_writes_it(vesselsplat: Cli, tmp_path: Path) -> None:
    page = tmp_path / "out" / "case.html"
    call = vesselsplat("summary", page, *PICTURES[:2], "--title", "Two", "--note", "first", "--notes", "both")
    assert (call.code, call.out) == (0, f"{page}\n")
    facts = facts_in(page.read_text())
    assert [one["note"] for one in facts["pictures"]] == ["first", ""]
    assert (facts["title"], facts["notes"]) == ("Two", "both")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("page.txt", PICTURES[0]), r"expected the name of an \.html file, got page\.txt"),
        (("page.html", BEFORE / "photo.png"), "expected an image saved by VesselSplat, found no provenance"),
        (("page.html", BEFORE / "depth.npy"), "expected an image that browsers show, PNG or JPEG"),
        (("page.html", BEFORE / "none.png"), "expected an image that VesselSplat saved, got no such file"),
        (("page.html", PICTURES[0], "--note", "a", "--note", "b"), "at most a --note per image, got 2 for 1"),
        (("page.html", PICTURES[0], "--title", "x" * 101), "length of at most 100, got 101"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(
    arguments: tuple[object, ...], said: str, vesselsplat: Cli, tmp_path: Path
) -> None:
    call = vesselsplat("summary", tmp_path / str(arguments[0]), *arguments[1:])
    assert call.code == 2
    assert re.search(said, call.error)
    assert call.error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_image_that_goes_while_the_page_is_made_stops_it(tmp_path: Path) -> None:
    gone = tmp_path / "gone.png"
    wanted = Summary("A", "2026-01-31", "", ((gone, ""),))
    request = ExportRequest(tmp_path, "page", ".html", wanted, Opened(files=wanted.files))
    with pytest.raises(OSError, match="gone"):
        list(export(request))
    assert list(tmp_path.iterdir()) == []


def test_json_of_the_record_is_json(tmp_path: Path) -> None:
    """Nothing in it ends the element that it stands in."""
    page = page_of(tmp_path / "page.html", (PICTURES[0], "</script>"))
    text = re.findall(r'id="provenance">(.*?)</script>', page, re.DOTALL)[0]
    assert json.loads(text)["pictures"][0]["note"] == "</script>"
