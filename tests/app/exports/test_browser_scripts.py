"""What the page's scripts do, run by Node.js where there is one: the order of drawing, keys and playing."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from renderer.draw.sorting import depth_order

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node.js")
STUBS = """
const said = [], drawn = [];
const element = () => ({ set textContent(text) { said.push(text); }, setAttribute() {}, value: 0 });
const elements = {}, window = {}, canvas = {}, scene = { frames: 10, seconds: 2 };
const document = { getElementById: (name) => elements[name] ??= element() };
let clock = 1000, waiting = null;
const performance = { now: () => clock };
const requestAnimationFrame = (next) => { waiting = next; };
const viewer = { time: 0, resets: 0, draw() { drawn.push(this.time); }, reset() { this.resets++; } };
const turn = (now) => { const next = waiting; waiting = null; next(now); };
const press = (given) => {
  const event = { target: { tagName: "BODY" }, prevented: false, ...given };
  event.preventDefault = () => { event.prevented = true; };
  window.onkeydown(event);
  return event.prevented;
};
"""


def script(name: str) -> str:
    return files("app.exports.browser").joinpath(name).read_text(encoding="utf-8")


def run(code: str, given: object = None) -> Any:
    """What `code` leaves in `answer`; it has `given`."""
    whole = f"const given = {json.dumps(given)}; {code}; console.log(JSON.stringify(answer));"
    done = subprocess.run(
        [str(NODE), "-"], input=whole, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def controls(code: str) -> Any:
    return run(f"{STUBS} {script('controls.js')} listen(viewer); {code}")


def order(depths: list[float]) -> list[int]:
    found = re.search(r"^function descending.*?^}", script("viewer.js"), re.DOTALL | re.MULTILINE)
    assert found is not None
    code = """
    const values = Float32Array.from(given), places = Uint32Array.from(given.keys());
    descending(values, places, new Uint32Array(given.length));
    const answer = [...places];"""
    return [int(place) for place in run(found[0] + code, depths)]


@pytest.mark.parametrize("far", [6.0, 5000.0, 1e30])
def test_the_order_is_that_of_the_renderers_however_near_depths_are(far: float) -> None:
    random = np.random.default_rng(1)
    near = random.choice(np.float32([5, 5.000001, 5.0001, 50, 50.00001, 0.01]), 300)
    depths = np.float32([*near, far, *random.uniform(1, 6, 300)])
    assert order(depths.tolist()) == depth_order(depths, "float32")[::-1].tolist()


@pytest.mark.parametrize(
    ("shown", "expected"),
    [
        (True, {"39": [[0, 1]], "39.25": [[0, 1], [1, 0.5]], "39.75": [[0, 0.5], [1, 1]], "40": [[1, 1]]}),
        (False, {"32": [[0, 1]], "36": [[0, 1], [1, 0.5]], "44": [[0, 0.5], [1, 1]], "48": [[1, 1]]}),
    ],
)
def test_windows_give_way_to_each_other_as_in_the_model(shown: bool, expected: dict[str, object]) -> None:
    """And where a page of before 0.14.0 had them overlap, all over that."""
    windows = [{"id": 0, "first": 0, "last": 48}, {"id": 1, "first": 32, "last": 79}]
    if shown:
        windows = [{**windows[0], "shown": [-1, 40]}, {**windows[1], "shown": [39, 80]}]
    found = re.search(r"^function present.*?^}", script("viewer.js"), re.DOTALL | re.MULTILINE)
    assert found is not None
    code = """
    const scene = { frames: 80 }, windows = given.windows;
    const seen = (frame) => present(frame / 80).map((one) => [one.id, one.fade]);
    const answer = Object.fromEntries(given.frames.map((frame) => [frame, seen(Number(frame))]));"""
    answer = run(found[0] + code, {"windows": windows, "frames": list(expected)})
    assert answer == expected


def test_keys_of_the_browser_itself_are_left_to_it() -> None:
    assert controls("""
    const held = [{ key: "r", ctrlKey: true }, { key: "r", metaKey: true }, { key: " ", ctrlKey: true },
                  { key: "ArrowLeft", altKey: true }, { key: "x" }];
    const answer = [held.map(press), viewer.resets, viewer.time]""") == [[False] * 5, 0, 0]
    assert controls("""
    const own = [{ key: "r" }, { key: "R", shiftKey: true }, { key: "ArrowRight" }, { key: "ArrowRight" },
                 { key: "ArrowLeft" }];
    const answer = [own.map(press), viewer.resets, viewer.time]""") == [[True] * 5, 2, pytest.approx(0.1)]


def test_a_frame_that_began_before_the_click_does_not_go_back_in_time() -> None:
    """Browsers give the time at which the frame began."""
    assert controls("press({ key: ' ' }); turn(995); turn(1195); const answer = drawn") == [
        0,
        pytest.approx(0.1),
    ]


def test_a_page_that_cannot_draw_says_so_and_offers_nothing_that_does_nothing() -> None:
    found = re.search(r"^function fail.*?^}", script("viewer.js"), re.DOTALL | re.MULTILINE)
    assert found is not None
    code = """
    const message = { hidden: true }, document = { body: {}, getElementById: () => message };
    try { fail("no WebGL2"); } catch {}
    const answer = [message, document.body.className];"""
    assert run(found[0] + code) == [{"hidden": False, "textContent": "no WebGL2"}, "failed"]
    assert ".failed canvas, .failed footer { visibility: hidden; }" in script("viewer.css")
