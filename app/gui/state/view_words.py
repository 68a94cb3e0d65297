"""What the 3D view says of itself: what it is of, how new, how fine, and what it rests on."""

from __future__ import annotations

from app.files.legible import legible, named
from app.gui.state.app_state import AppState
from app.gui.state.panes import fill_tags, frame_share, hides_enhancement, progress_tags
from app.gui.state.tags import Tag, Tone
from app.gui.views.measurement import LEAST_CORNERS, Measurement
from app.scenes.scene import Scene
from app.scenes.view_request import FrameImage, ViewRequest


def frame_over(state: AppState, shown: ViewRequest) -> FrameImage | None:
    """The frame that lies over the view on screen. A difference to it shows it already, and one that is still
    of another camera would be mixed with it."""
    seen, own = shown.camera, shown.scene.camera_at(shown.time)
    is_clips = seen == own.resized(seen.width, seen.height)
    return state.frame_image if is_clips and shown.kind != "difference" else None


def view_tags(state: AppState, shown: ViewRequest | None) -> tuple[Tag, ...]:
    """Of the view that is on screen, None: there is none yet; of two, the first speaks for both."""
    if shown is None:
        return _waiting_tags(state)
    model, second = shown.scene, state.scene.second.model
    tags: list[Tag] = []
    if state.shows_other_clip:
        tags.append(Tag(f"OF ANOTHER CLIP · {legible(model.title)}", "caution"))
    tags += [*progress_tags(state, model), *_model_tags(state, shown), *_guess_tags(model)]
    if hides_enhancement(state, model) and not _is_under_frame(state, shown):
        tags.append(Tag(f"OF {str(model.record.input).upper()} FRAMES · not white light", "caution"))
    if model is not second:
        tags += _hand_tags(state, shown)
    if shown.kind == "color":
        tags += fill_tags(shown.background)
    if shown.kind not in ("color", "difference"):
        tags.append(Tag(f"{shown.kind.upper()} · not how it looks", "enhanced"))
    if shown.reduced:
        tags.append(Tag("REDUCED RESOLUTION while moving", "caution"))
    return tuple(tags)


def _waiting_tags(state: AppState) -> tuple[Tag, ...]:
    """Why there is no picture yet."""
    preparation = state.window.preparation
    if preparation is None or not state.lacks("3D view"):
        return (Tag("DRAWING…", "caution"),)
    left = preparation.left("3D view")
    return Tag("PREPARING…", "caution"), Tag(f"One-time preparation of the 3D view: {left}")


def _model_tags(state: AppState, shown: ViewRequest) -> tuple[Tag, ...]:
    """Which model it is, at which moment, and which frames it was trained on."""
    model, second = shown.scene, state.scene.second.model
    moment = model.moment(shown.time)
    if second is not None:
        other = state.scene.model if model is second else second
        return (Tag(f"{_made_by(model, other)} · {moment}", "enhanced"),)
    if not model.is_of_run:
        return (Tag(f"SPLAT FILE · {legible(model.name)}"),)
    head = Tag(f"RECONSTRUCTION · {moment}")
    if not model.record.trained_on:
        return (head,)
    tone: Tone = "enhanced" if model.record.input == "enhanced" else "plain"
    return head, Tag(f"from {legible(model.record.trained_on)}", tone)


def _made_by(model: Scene, other: Scene | None) -> str:
    """What tells a reconstruction from another: its method and frames, its name where these are the same."""

    def told(one: Scene) -> str:
        frames, config = one.record.input, one.record.config
        if not frames or config is None:
            return legible(one.name)
        return f"{named(config.method)} · {frames} frames"

    same = other is not None and told(other) == told(model)
    return legible(model.name) if same else told(model)


def _guess_tags(model: Scene) -> tuple[Tag, ...]:
    """What it rests on that nobody measured."""
    lens = model.record.clip.calibration if model.record.clip else None
    is_guess = {
        "depth": model.is_guessed,
        "camera poses": model.poses_are_estimated,
        "lens": lens is not None and lens.found is not None,
    }
    guesses = [name for name, is_so in is_guess.items() if is_so]
    guessed = " and ".join(filter(None, (", ".join(guesses[:-1]), *guesses[-1:])))
    return (Tag(f"ESTIMATED {guessed}", "caution"),) if guessed else ()


def _is_under_frame(state: AppState, shown: ViewRequest) -> bool:
    """The frame lies over the view, and can hide it."""
    return state.scene.viewer.snapped and frame_over(state, shown) is not None


def _hand_tags(state: AppState, shown: ViewRequest) -> list[Tag]:
    """What the hand does, and from where it is seen."""
    tags: list[Tag] = []
    viewer = state.scene.viewer
    if viewer.flying:
        tags.append(Tag(f"FLYING · W A S D Q E · speed {viewer.speed:.2f} · G to stop", "caution"))
    if viewer.measuring:
        tags.append(Tag(f"MEASURING on the model · {_next_click(viewer.measurement)}", "caution"))
    if viewer.snapped and state.frame_image is None:
        tags.append(Tag("READING THE FRAME…", "enhanced"))
    elif viewer.snapped and shown.kind == "difference":
        tags.append(Tag("DIFFERENCE to the frame", "enhanced"))
    elif viewer.snapped:
        share = 100 * frame_share(state, shown.scene)
        tone: Tone = "caution" if share else "enhanced"
        tags.append(Tag(f"FRAME {share:.0f} % over the reconstruction", tone))
    elif state.scene.kind == "difference":
        tags.append(Tag("DIFFERENCE needs the clip's camera: press C", "caution"))
    if viewer.free is not None:
        tags.append(Tag("FREE VIEW · not the endoscope's view"))
    return tags


def _next_click(measured: Measurement) -> str:
    """What comes next, for a line that has begun."""
    count = len(measured.points)
    if count == 1:
        return "click the second point"
    if count == 0 or measured.closed:
        return "click two points"
    more = "Shift+click adds a point"
    return more if count < LEAST_CORNERS else f"{more}, on the first one closes an area"
