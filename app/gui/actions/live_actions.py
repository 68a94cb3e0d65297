"""What a person does with a live source, as functions on the state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from app.errors import UserError
from app.files.provenance import stamp
from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.state.live import Eyes, Live
from app.gui.work.background import Failure
from app.gui.work.live_devices import DevicesRequest, Found
from app.live.address import Device, LiveAddress, LiveInput, address_of, input_of
from app.live.igtl.sender import Sender
from app.live.picture import LIVE, LivePicture
from app.live.recorder import Recorder, What
from app.live.sources.source import Wish
from app.live.start import LiveStart
from renderer.clip import ByteImage, Clip
from renderer.readers.clip_options import FIELD_OF_VIEW
from renderer.readers.image_folders.frames import assumed_camera
from renderer.readers.new_clip import new_clip


def choose_source(state: AppState) -> None:
    """Open the dialog, and look for devices anew."""
    choice = state.live.choice
    choice.shown, choice.looks, choice.found, choice.trouble = True, choice.looks + 1, None, ""


def type_address(state: AppState, text: str) -> None:
    state.live.choice.text, state.live.choice.trouble = text, ""


def choose_wish(state: AppState, wish: Wish) -> None:
    """What the next source is asked for."""
    state.live.choice.wish = wish


def choose_eyes(state: AppState, eyes: Eyes) -> None:
    """Where the eyes of the next source are."""
    state.live.choice.eyes, state.live.choice.trouble = eyes, ""


def type_right(state: AppState, text: str) -> None:
    """Change the address of the right eye's source."""
    state.live.choice.right, state.live.choice.trouble = text, ""


def devices_wish(state: AppState) -> DevicesRequest | None:
    return DevicesRequest(state.live.choice.looks) if state.live.choice.shown else None


def take_devices(state: AppState, request: DevicesRequest, answer: Found | Failure) -> None:
    if isinstance(answer, Found) and request.looks == state.live.choice.looks:
        state.live.choice.found = answer


def open_typed(state: AppState) -> None:
    """The address in the dialog."""
    _open(state, lambda: address_of(state.live.choice.text, _known(state)))


def open_device(state: AppState, device: Device) -> None:
    _open(state, lambda: LiveAddress("device", device.where, device.name))


def play_file(state: AppState, path: Path) -> None:
    """Open a file as a source that plays as if it were live."""
    _open(state, lambda: LiveAddress.of_file(path))


def _open(state: AppState, address: Callable[[], LiveAddress]) -> None:
    """With the eyes that are chosen; an address that is none is said in the dialog."""
    choice = state.live.choice
    try:
        if choice.eyes == "two":
            source = input_of(address(), choice.right, "auto", _known(state))
        else:
            source = input_of(address(), None, choice.eyes)
    except UserError as error:
        choice.trouble = str(error)
        return
    go_live(state, source, choice.wish)


def _known(state: AppState) -> tuple[Device, ...]:
    found = state.live.choice.found
    return () if found is None else found.devices


def go_live(state: AppState, source: LiveInput, wish: Wish) -> None:
    """Show it from the next frame on, after a question where something is not saved."""

    def go() -> None:
        state.live.choice.shown, state.live.asked = False, (source, wish)
        state.source.opening = state.window.banner = None

    actions.leave_clip(state, go)


def begin(state: AppState, start: LiveStart) -> None:
    """Begin with the live source that the window was opened on."""
    go_live(state, start.source, Wish())
    if start.endpoint is not None:
        state.live.endpoint, state.live.send_asked = start.endpoint, True


def leave_live(state: AppState) -> None:
    """End it; the last picture stays until something else is opened."""
    state.live.leaving = True


def toggle_freeze(state: AppState) -> None:
    """Hold the picture while the source goes on, or follow the source again; of a clip, its frame."""
    live = state.live
    if live.session is None:
        actions.toggle_freeze(state)
    elif live.still is not None:
        live.still, state.source.clip = None, live.clip
    elif live.newest is not None and live.clip is not None:
        live.still = state.source.clip = still_of(live.newest)


def still_of(picture: LivePicture) -> Clip:
    """The frame as a clip of its own, by the name under which it is kept when something is made of it."""
    return clip_of(Path(f"live-{stamp()}.png"), picture.original, picture.pixel_aspect)


def clip_of(path: Path, image: ByteImage, pixel_aspect: float = 1.0) -> Clip:
    """A clip of one frame of which no file is there."""
    camera = assumed_camera(FIELD_OF_VIEW, (image.shape[1], image.shape[0]), pixel_aspect)
    images, labels = (image,), (path.name,)
    clip = new_clip(path, LIVE, cameras=(camera,), labels=labels, read_image=lambda index: images[index])
    return replace(clip, pixel_aspect=pixel_aspect)


def held(state: AppState) -> AppState:
    """With the live frame that is on screen now as a clip of its own, for what is made of it later; as it is
    where nothing is live."""
    shown, clip = state.picture.pictures, state.source.clip
    if not state.live.flows or shown is None or clip is None:
        return state
    still = clip_of(Path(f"live-{stamp()}.png"), shown.original, clip.pixel_aspect)
    pictures = replace(shown, request=replace(shown.request, clip=still))
    picture = replace(state.picture, pictures=pictures)
    return replace(state, source=replace(state.source, clip=still), picture=picture)


def following(source: LiveInput, live: Live, first: LivePicture) -> Clip:
    """The clip that stands for what is live: its frame is the newest."""

    def newest(index: int) -> ByteImage:
        picture = first if live.newest is None else live.newest
        return (picture.original,)[index]

    clip = clip_of(Path("live.png"), first.original, first.pixel_aspect)
    return replace(clip, name=source.name, labels=(source.name,), read_image=newest)


def choose_what(state: AppState, what: What) -> None:
    """What the next recording is of."""
    state.live.what = what


def toggle_recording(state: AppState) -> None:
    """Begin one in the folder of exports, or end it: what waits is written, and the update tells its end."""
    live = state.live
    if live.recorder is not None:
        live.recorder.end()
        return
    if live.session is None or live.source is None:
        return
    path = state.export_folder / f"live-{stamp()}-{live.what.replace(' ', '-')}.mp4"
    live.recorder = Recorder(path, live.what, live.source.name)


def toggle_sending(state: AppState) -> None:
    """Let other programs fetch the pictures, or close their connections."""
    live = state.live
    if live.sender is not None:
        live.sender.end()
        live.sender = None
        return
    if live.session is None:
        return
    try:
        live.sender = Sender(live.endpoint)
    except UserError as error:
        actions.fail(state, str(error))
        return
    if live.endpoint.warning:
        actions.fail(state, live.endpoint.warning)
