"""Stereo live sources: both eyes in one frame or from two sources, paired, recorded, opened with depth."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from app.errors import UserError
from app.live.address import LiveInput, address_of, input_of
from app.live.picture import LivePicture, LiveSetting
from app.live.recorder import Recorder
from app.live.session import LiveSession
from app.live.sources.both_eyes import BothEyesSource
from app.live.sources.opening import open_input, open_source
from app.live.sources.paired import PairedSource
from app.live.sources.pairing import Pair, Pairing
from app.live.sources.source import Arrived, Source, Wish
from assets import phantom_path
from renderer.clip import ClipError
from renderer.readers.clip_options import ClipOptions, Stereo, StereoLayout
from renderer.sources import open_clip
from tests.app.conftest import Cli
from tests.app.live.painted import PaintedSource, painted, wait_for
from tests.renderer.eyes import BASELINE, Eyes, look
from tests.renderer.readers.numbered import encoded

PLAIN = LiveSetting(None)
FIELD_OF_VIEW = math.degrees(2 * math.atan(0.5 / 0.89))


@contextmanager
def live(
    open_source: Callable[[], Source], *recipients: Callable[[LivePicture], None]
) -> Iterator[LiveSession]:
    session = LiveSession(open_source, PLAIN, recipients=recipients)
    try:
        yield session
    finally:
        session.close()


def paired(left: PaintedSource, right: PaintedSource) -> Callable[[], Source]:
    return lambda: PairedSource((lambda: left, lambda: right), ("cam L", "cam R"))


def pairs_of(*arrivals: tuple[int, float]) -> tuple[list[Pair], Pairing]:
    """Of frames of the left eye (0) and the right one (1) at these milliseconds."""
    pairing = Pairing()
    came = (pairing.add(eye, Arrived(partial(painted, 90), ms / 1000, ms / 1000)) for eye, ms in arrivals)
    return [pair for pair in came if pair is not None], pairing


def test_eyes_that_arrive_within_half_a_frame_are_a_pair() -> None:
    """Both at 25 frames a second, the right one 12 ms later: each finds its own."""
    arrivals = [(eye, 40 * number + 12 * eye) for number in range(6) for eye in (0, 1)]
    found, _ = pairs_of(*arrivals)
    assert [1000 * one.left.at for one in found] == pytest.approx([0, 40, 80, 120, 160, 200])
    assert [1000 * one.apart for one in found] == pytest.approx([12] * 6)
    assert sum(one.unpaired + one.late for one in found) == 0


def test_eyes_further_apart_are_left_out_and_counted_once() -> None:
    """The right one 30 ms after the left one is 10 ms before the next left one: with that it is paired."""
    arrivals = [(eye, 40 * number + 30 * eye) for number in range(6) for eye in (0, 1)]
    found, _ = pairs_of(*arrivals)
    assert [1000 * one.apart for one in found] == pytest.approx([10] * 5)
    assert [one.unpaired for one in found] == [1, 0, 0, 0, 0]


def test_half_a_frame_is_that_of_the_rate_measured_and_late_frames_give_way() -> None:
    """At 100 frames a second 8 ms are too many; of a left eye twice as quick, every second frame is late."""
    quick = [(eye, 10 * number + 8 * eye) for number in range(12) for eye in (0, 1)]
    found, pairing = pairs_of(*quick)
    assert pairing.frame == pytest.approx(0.01)
    assert all(1000 * one.apart < 5 for one in found[3:])
    both = sorted(
        [(0, 20.0 * number) for number in range(12)] + [(1, 40.0 * number + 1) for number in range(6)],
        key=lambda one: one[1],
    )
    found, _ = pairs_of(*both)
    assert [1000 * one.left.at for one in found] == pytest.approx([40 * number for number in range(6)])
    assert sum(one.late for one in found) == 5


def test_the_left_eye_is_shown_and_both_are_kept() -> None:
    seen = list[LivePicture]()
    with live(paired(PaintedSource([120] * 60), PaintedSource([60] * 60)), seen.append) as session:
        wait_for(lambda: len(seen) > 10, "pairs")
        status = session.status()
    assert np.array_equal(seen[3].original, painted(120))
    assert seen[3].pair is not None
    assert seen[3].pair.layout == "side-by-side"
    assert np.array_equal(seen[3].pair.image, np.concatenate((painted(120), painted(60)), axis=1))
    assert status.apart is not None
    assert 0 <= status.apart.median < 10
    assert status.told.startswith("two sources")


@pytest.mark.parametrize(
    ("right", "signal", "said"),
    [
        (PaintedSource([60] * 5, then="lose"), "lost", "right eye: unplugged"),
        (PaintedSource([60] * 5, size=(48, 60)), "failed", "64x48 from cam L and 60x48 from cam R"),
    ],
    ids=["unplugged", "another size"],
)
def test_an_eye_that_is_lost_is_named(right: PaintedSource, signal: str, said: str) -> None:
    with live(paired(PaintedSource([120] * 400), right)) as session:
        wait_for(lambda: session.status().signal == signal, signal)
        assert said in session.status().reason


def test_a_silent_eye_is_named(monkeypatch) -> None:
    monkeypatch.setattr("app.live.sources.paired.SILENCE", 0.3)

    class Hanging(PaintedSource):
        def read(self) -> Arrived | None:
            if self._given == len(self.levels):
                time.sleep(1.0)
            return super().read()

    with live(paired(PaintedSource([120] * 400), Hanging([60] * 5))) as session:
        wait_for(lambda: session.status().signal == "lost", "the loss")
        assert "right eye: no frame from cam R" in session.status().reason


def test_what_cannot_be_halved_fails_at_once() -> None:
    with live(lambda: BothEyesSource(PaintedSource([90] * 9, size=(48, 65)), "side-by-side")) as session:
        wait_for(lambda: session.is_over, "the end")
        assert session.status().reason == "expected an even width of side-by-side stereo, got 65x48"
        assert session.status().signal == "failed"


@pytest.mark.parametrize(("aspect", "shape"), [(1.0, ", squeezed to half its width"), (2.0, "")])
def test_whether_an_eye_is_squeezed_is_told_by_its_shape_on_screen(aspect: float, shape: str) -> None:
    class Shaped(PaintedSource):
        def read(self) -> Arrived | None:
            arrived = super().read()
            return None if arrived is None else replace(arrived, pixel_aspect=aspect)

    source = BothEyesSource(Shaped([90]), "side-by-side")
    source.read()
    assert source.told == f"64 × 48, side-by-side stereo{shape}"


@pytest.fixture(scope="module")
def eyes() -> Eyes:
    return look(0, width=192, height=144, seed=41, noise=0.5, n_frames=2)


@pytest.fixture(scope="module")
def film(tmp_path_factory, eyes: Eyes) -> Path:
    """Both eyes of one moment side by side, 20 frames of it."""
    whole = np.concatenate((eyes.left.image, eyes.right.image), axis=1)
    return encoded(tmp_path_factory.mktemp("film") / "eyes.mp4", [whole] * 20, options={"qp": "0"})


def test_a_recording_of_a_stereo_source_opens_with_the_depth_of_the_scene(
    vesselsplat: Cli, film: Path, eyes: Eyes, tmp_path: Path
) -> None:
    made = tmp_path / "live.mp4"
    done = vesselsplat("live", film, "--stereo", "side-by-side", "--once", "--record", made, "--fps", "10")
    assert done.code == 0, done.error
    assert "side-by-side stereo" in done.out
    clip = open_clip(made, ClipOptions(field_of_view=FIELD_OF_VIEW, baseline=BASELINE))
    assert (clip.size, clip.depth_origin, clip.unit) == ((192, 144), "stereo", "mm")
    frame = clip.read_frame(len(clip) - 1)
    assert frame.depth is not None
    known = eyes.seen & (frame.depth > 0)
    assert known.sum() > 0.75 * eyes.seen.sum()
    apart = np.abs(frame.camera.fx * BASELINE / frame.depth[known] - eyes.disparity[known])
    assert np.median(apart) < 0.3
    assert "side-by-side" in vesselsplat("info", made).out
    again = open_input(LiveInput(address_of(str(made))), Wish())
    assert isinstance(again, BothEyesSource)


def test_enhanced_recordings_hold_the_left_eye(film: Path, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "a.mp4", "side by side", "a source")
    source = LiveInput(address_of(str(film)), stereo="side-by-side")
    with live(partial(open_input, source, Wish()), recorder.add):
        wait_for(lambda: recorder.state.pictures > 2, "pictures")
    done = recorder.finish()
    clip = open_clip(done.path)
    assert (clip.size, clip.read_right) == ((384, 144), None)


@pytest.mark.parametrize(
    ("right", "stereo", "said"),
    [
        ("nosuch", "auto", "right eye: expected a capture device"),
        (" ", "auto", "right eye: expected a capture device"),
        ("5", "auto", "expected another source for the right eye"),
        ("77", "top-bottom", "expected a source of the right eye or both eyes in one"),
    ],
)
def test_two_sources_are_two_and_of_one_eye_each(right: str, stereo: Stereo, said: str) -> None:
    with pytest.raises(UserError, match=said):
        input_of(address_of("5"), right, stereo)


def test_two_files_start_together(film: Path) -> None:
    """However long opening takes: else pairs would be of two moments."""

    def slowly() -> Source:
        time.sleep(0.03)
        return open_source(address_of(str(film)), Wish())

    opens = partial(open_source, address_of(str(film)), Wish()), slowly
    source = PairedSource(opens, ("left", "right"))
    came = [source.read() for _ in range(5)]
    source.close()
    assert all(one is not None and one.apart is not None and one.apart < 0.01 for one in came)
    assert sum(one.unpaired for one in came if one is not None) == 0


def test_two_clips_of_two_sizes_are_refused(vesselsplat: Cli, film: Path) -> None:
    done = vesselsplat("live", film, "--right", phantom_path())
    assert done.code == 2
    assert "expected two eyes of one size, got 384x144 from eyes.mp4" in done.error


@pytest.mark.parametrize("layout", ["side-by-side", "top-bottom"])
def test_a_squeezed_eye_says_so(layout: StereoLayout) -> None:
    size = (60, 80) if layout == "side-by-side" else (40, 60)
    source = BothEyesSource(PaintedSource([90] * 3, size=size), layout)
    arrived = source.read()
    assert arrived is not None
    assert arrived.stereo == layout
    assert "squeezed to half" in source.told
    with pytest.raises(ClipError, match="even height"):
        BothEyesSource(PaintedSource([90], size=(41, 60)), "top-bottom").read()
