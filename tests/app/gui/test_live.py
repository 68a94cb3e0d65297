"""A live source in the window: shown, frozen, saved, recorded, lost, and left, by mouse and keys."""

from __future__ import annotations

import socket
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from app.__main__ import main
from app.gui.actions import actions, live_actions
from app.gui.commands.keys import chord
from app.gui.state.app_state import AppState
from app.gui.state.live_words import counts, is_not_live, live_tags
from app.gui.state.panes import why_not
from app.gui.work.settings import Places
from app.live.address import LiveInput, address_of
from app.live.picture import LIVE
from app.live.sources.source import Wish
from app.live.start import LiveStart
from assets import phantom_path
from renderer.sources import open_clip
from tests.app.gui.driver import Driver, enhanced, is_settled, wait
from tests.app.live.test_igtl import client_of, free, listens

Context = imgui.test_engine.TestContext
PHANTOM = LiveInput(address_of(str(phantom_path())))


def tags(state: AppState) -> str:
    return " ".join(tag.text for tag in live_tags(state.live))


def made(state: AppState) -> int:
    return state.live.newest.number if state.live.newest is not None else 0


@pytest.mark.display
def test_from_the_dialog_to_a_recording_that_opens(places: Places) -> None:
    """Address typed, live with its delay, a slider moved, frozen, thawed, saved, recorded, closed."""
    driver = Driver(places)
    state = driver.state

    def drive(ctx: Context) -> None:
        ctx.key_press(chord("Ctrl+L"))
        wait(ctx, lambda: state.live.choice.found is not None, "the list of devices")
        ctx.item_click("//Open live source/##address")
        ctx.key_chars_replace("nosuch")
        ctx.item_click("//Open live source/###typed")
        assert "expected a capture device" in state.live.choice.trouble
        ctx.item_click("//Open live source/##address")
        ctx.key_chars_replace_enter(str(phantom_path()))
        wait(ctx, lambda: state.live.flows and made(state) > 3, "live pictures")
        assert not state.live.choice.shown
        wait(ctx, lambda: tags(state).startswith("LIVE"), "the tag")
        status = state.live.status
        assert status is not None
        assert status.to_screen is not None
        assert 0 < status.to_screen.median < 2000
        assert "freeze" in why_not(state, "clahe")

        ctx.item_input_value("//Enhancement/**/##d_factor", 0.25)
        wait(ctx, lambda: _params(state).d_factor == 3.0, "the slider in the live picture")

        ctx.key_press(chord("F"))
        wait(ctx, lambda: is_settled(state) and state.live.still is not None, "the frozen picture")
        held, count = enhanced(state), made(state)
        assert "FROZEN" in tags(state)
        assert is_not_live(state.live)
        wait(ctx, lambda: made(state) > count + 3, "the source behind it")
        assert np.array_equal(held, enhanced(state))
        ctx.key_press(chord("S"))
        wait(ctx, lambda: len(list(places.pictures.glob("live-*.png"))) == 2, "the saved image and its frame")
        ctx.key_press(chord("F"))
        wait(ctx, lambda: state.live.flows and not is_not_live(state.live), "live again")

        ctx.key_press(chord("Ctrl+Shift+L"))
        wait(ctx, lambda: _recorded(state) > 5, "a recording")
        assert "RECORDING" in tags(state)
        ctx.key_press(chord("Ctrl+Shift+L"))
        wait(ctx, lambda: state.live.recorder is None, "its end")
        (film,) = places.pictures.glob("live-*-original.mp4")
        actions.open_path(state, film)
        wait(ctx, lambda: is_settled(state) and state.live.session is None, "the recording as a clip")
        assert state.source.clip is not None
        assert state.source.clip.format == "video"
        assert len(state.source.clip) > 5

    driver.run(drive)
    shown = next(places.pictures.glob("live-*-shown.png"))
    assert main(["replay", str(shown)]) == 0


def _params(state: AppState):  # type: ignore[no-untyped-def]
    assert state.picture.pictures is not None
    return state.picture.pictures.request.params


def _recorded(state: AppState) -> int:
    return state.live.recording.pictures if state.live.recording is not None else 0


@pytest.mark.display
def test_a_source_that_ends_never_looks_live(places: Places) -> None:
    driver = Driver(places)
    state = driver.state
    live_actions.go_live(state, PHANTOM, Wish(frames_per_second=40.0, loop=False))

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: made(state) > 0, "live pictures")
        wait(ctx, lambda: tags(state).startswith("ENDED"), "the end")
        assert is_not_live(state.live)
        assert "last frame shown" in tags(state)
        ctx.item_click("**/Close source")
        wait(ctx, lambda: state.live.session is None and is_settled(state), "the last picture as a still")
        assert state.source.clip is not None
        assert state.source.clip.format == LIVE
        assert not live_tags(state.live)

    driver.run(drive)


@pytest.mark.display
def test_others_fetch_what_is_live_while_the_switch_is_on(places: Places) -> None:
    driver = Driver(places)
    state, taken = driver.state, free()
    live_actions.begin(state, LiveStart(PHANTOM, taken))

    def said() -> str:
        return counts(state.live, state.live.status) if state.live.status is not None else ""

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: state.live.flows and state.live.sender is not None, "live pictures")
        with client_of(taken) as client:
            wait(ctx, lambda: said().endswith(f"sending to {taken}, 1 client"), "the client")
            wait(ctx, lambda: state.live.sending is not None and state.live.sending.sent > 3, "images")
            assert client.get_latest_messages()[0].image.shape[3] == 3
            ctx.item_click("**/###send")
            wait(ctx, lambda: "sending" not in said(), "the end of it")
            wait(ctx, lambda: not listens(taken), "the end of the connection")
        with socket.create_server((taken.host, taken.port)):
            ctx.item_click("**/###send")
            wait(ctx, lambda: state.window.banner is not None, "why it cannot")
        assert state.window.banner is not None
        assert f"cannot send at {taken}" in state.window.banner.message
        assert state.live.sender is None

    driver.run(drive)


@pytest.mark.display
def test_what_cannot_be_reached_says_so_and_can_be_given_up(places: Places) -> None:
    driver = Driver(places)
    state = driver.state
    live_actions.go_live(state, LiveInput(address_of("77")), Wish())

    def drive(ctx: Context) -> None:
        wait(ctx, lambda: state.window.banner is not None, "the reason")
        assert state.window.banner is not None
        assert "device 77 cannot be opened" in state.window.banner.message
        assert state.opens == "Connecting to the live source…"
        ctx.item_click("//##banner/**/Stop waiting")
        wait(ctx, lambda: state.live.session is None, "the end of it")
        assert state.is_empty
        assert not state.opens

    driver.run(drive)


def test_a_frozen_frame_keeps_its_pixels_and_names_no_folder() -> None:
    image = open_clip(phantom_path()).read_image(3)
    clip = live_actions.clip_of(Path("live-1.png"), image)
    assert np.array_equal(clip.read_image(0), image)
    assert clip.path == Path("live-1.png")
    assert (clip.format, len(clip), clip.size) == (LIVE, 1, (image.shape[1], image.shape[0]))
