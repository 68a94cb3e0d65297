"""What each pane shows and says of itself, worked out from the state. No ImGui, no OpenGL."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from app.enhancement.frame_enhancer import Pictures
from app.enhancement.measures import VesselsSeen
from app.enhancement.methods import PAPER, VESSEL, EnhancementSettings, preset_of
from app.enhancement.settable import ENHANCED, ORIGINAL, RENDER, Mode
from app.exports.comparison_images import Difference, DifferenceRequest, Other, OtherRequest
from app.exports.sheet import describe
from app.files.legible import grouped, legible, named
from app.gui.state.app_state import AppState
from app.gui.state.live_words import live_tags
from app.gui.state.tags import Tag, cautions
from app.gui.views.comparison import SIDES, Side, label_of
from app.scenes.backgrounds import Background
from app.scenes.scene import Scene
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.clip import BoolImage, ByteImage

TINTED: Final = Tag("TINTED · tools and mask", "caution")
STALE_SECONDS = 0.15
"""Younger than this, an update on its way is not worth a flashing tag."""
LONG_SECONDS = 3.0
"""After which a person wonders whether anything happens."""
FIRST_USE = "The first use of a method takes up to a minute."
"""Its kernels are compiled then, once on a computer, where the one-time preparation has not done it."""


@dataclass(frozen=True, eq=False)
class Pane:
    """A picture with what it is called."""

    image: ByteImage
    tags: tuple[Tag, ...]
    stale: bool = False
    """It shows an earlier request: the newest is still being worked on."""
    zebra: bool = False
    """Stripes are painted on clipped pixels."""
    tint: BoolImage | None = None
    """(H, W), True where it is to be tinted."""


def shown_mode(state: AppState) -> Mode:
    """As chosen; white light has no difference to itself."""
    mode = state.comparing.chosen.mode
    return "side by side" if mode == "difference" and not state.enhancement.active else mode


def why_not(state: AppState, source: str) -> str:
    """What a source still lacks, in a sentence; empty when it can be shown."""
    if state.live.flows and source not in (ORIGINAL, ENHANCED):
        return "Not while the source is live: freeze the frame first."
    if source in ("A", "B") and source not in state.enhancement.stored:
        return f"No settings are stored as {source} yet: Shift+{source} stores the current ones."
    if source == RENDER and not _renders(state):
        return "No reconstruction of this clip is open."
    if source == RENDER and is_undistorted_otherwise(state):
        return "Its images are undistorted otherwise than these: open its run to see them."
    if (
        source == RENDER
        and state.scene.model is not None
        and not state.scene.model.has_clip_frame(state.timeline.shown_index)
    ):
        return "The reconstruction covers a part of the clip without this frame."
    return ""


def _renders(state: AppState) -> bool:
    """The open model was made through this clip's cameras."""
    model, clip = state.scene.model, state.source.clip
    if model is None or clip is None or model.is_of_other(clip):
        return False
    if not (state.has_frames or len(model.cameras) == len(clip)):
        return False
    camera = model.cameras[0]
    return (camera.width, camera.height) == clip.size


def is_undistorted_otherwise(state: AppState) -> bool:
    """The open model is of images of this clip that are, as by a lens that its training has found."""
    model = state.scene.model
    known = None if model is None else model.record.clip
    return known is not None and known.calibration != state.source.options.calibration


def other_request(state: AppState, side: Side) -> OtherRequest | None:
    """What is to be made for a side; None where the frame or the present setting is shown."""
    source, pictures = state.comparing.chosen.source(side), state.picture_request
    if (
        source in (ORIGINAL, ENHANCED)
        or pictures is None
        or not state.enhancement.active
        or why_not(state, source)
    ):
        return None
    original = replace(pictures, params=None)
    # What has no statistics is not made again as they come, or are taken otherwise.
    alone = replace(original, scope="image", pixels="automatic", of_clip=None, tools=None)
    if source == RENDER:
        assert state.scene.model is not None
        return OtherRequest(alone, state.scene.model, state.background)
    look = _look(state, source)
    if look is None:
        return OtherRequest(alone, source)
    return OtherRequest(replace(pictures.with_params(look), params=None), look)


def _look(state: AppState, source: str) -> EnhancementSettings | None:
    """The parameters behind a source, None for a method without."""
    defaults: dict[str, EnhancementSettings] = {PAPER: EnhanceParams(), VESSEL: VesselParams()}
    stored = (look for slot, look in state.enhancement.stored.items() if slot == source)
    return next(stored, defaults.get(source))


def pane(state: AppState, pictures: Pictures, side: Side) -> Pane:
    """What a side shows now; it never looks enhanced without saying so, nor the reverse."""
    image, head, stale = _content(state, pictures, side)
    # What could mislead comes before details, which a small pane has no room for.
    tags = tuple(dict.fromkeys((head[0], *_state_tags(state, stale), *head[1:])))  # Each once.
    return Pane(image, tags, stale, state.comparing.chosen.zebra, tinted(state))


def original_tag(state: AppState) -> Tag:
    """Of images as they are in their file."""
    return Tag("ENHANCED BEFORE", "caution") if state.source.is_enhanced else Tag("ORIGINAL")


def source_label(state: AppState, source: str) -> str:
    """As lists and captions name it; of a file that was enhanced before none is original."""
    return "Enhanced before" if source == ORIGINAL and state.source.is_enhanced else label_of(source)


def _content(state: AppState, pictures: Pictures, side: Side) -> tuple[ByteImage, tuple[Tag, ...], bool]:
    source, original = state.comparing.chosen.source(side), pictures.original
    stale = state.pictures_are_stale
    tag = original_tag(state)
    if not state.enhancement.active:
        none = ": no difference" if state.comparing.chosen.mode == "difference" else ""
        said = tag if side == "left" else Tag(f"WHITE LIGHT · enhancement off{none}", "caution")
        return original, (said,), stale
    if source == ORIGINAL:
        return original, (tag,), stale
    if state.enhancement.peeking:
        return original, (Tag(f"{tag.text} · peek", "caution"),), stale
    if source == ENHANCED:
        if pictures.enhanced is None:
            return original, (Tag("PREPARING… original shown", "caution"), *_first_use(state)), stale
        return pictures.enhanced, (Tag("ENHANCED", "enhanced"), Tag(describe(pictures))), stale
    if reason := why_not(state, source):
        return original, (Tag(f"{tag.text} · nothing else to show", "caution"), Tag(reason)), stale
    return _other(state, original, side)


def _other(state: AppState, original: ByteImage, side: Side) -> tuple[ByteImage, tuple[Tag, ...], bool]:
    wanted = other_request(state, side)
    made = next(
        (other for other in state.comparing.others.values() if other.request == wanted),
        state.comparing.others.get(side),
    )
    if made is None or wanted is None or not _is_earlier(made.request, wanted):
        return original, (Tag("PREPARING… original shown", "caution"),), True
    return made.image, _named(state, side, made), made.request != wanted


def _is_earlier(made: OtherRequest, wanted: OtherRequest) -> bool:
    """The same thing at another moment of the clip or of the training."""
    if made.original.clip is not wanted.original.clip:
        return False
    now, then = wanted.by, made.by
    if isinstance(now, Scene) and isinstance(then, Scene):
        return now.name == then.name
    return now == then


def _named(state: AppState, side: Side, made: Other) -> tuple[Tag, ...]:
    source, model = state.comparing.chosen.source(side), state.scene.model
    if source == RENDER and model is not None:
        frames = model.record.trained_on
        what = f"RENDER · {legible(model.name)}" + (f" · from {legible(frames)}" if frames else "")
        return Tag(what, "enhanced"), *progress_tags(state, model), *fill_tags(made.request.background)
    if made.made is None:
        return (Tag(f"METHOD {named(source)}", "enhanced"),)
    head = f"STORED {source}" if source in ("A", "B") else f"METHOD {named(source)}, defaults"
    return Tag(head, "enhanced"), Tag(describe(made.made))


def progress_tags(state: AppState, model: Scene) -> tuple[Tag, ...]:
    """How far a model is whose training is not at its end."""
    if not model.live:
        return ()
    name = "LIVE PREVIEW" if state.runs.reconstruction.is_of(model.name) else "UNFINISHED"
    return (Tag(f"{name} · iteration {grouped(model.iteration)} / {grouped(model.iterations)}", "caution"),)


def fill_tags(background: Background) -> tuple[Tag, ...]:
    """What the lines over a fill mean that could pass for tissue."""
    return (Tag("HATCHED · not observed", "caution"),) if background == "smooth" else ()


def _state_tags(state: AppState, stale: bool) -> tuple[Tag, ...]:
    tags = [*live_tags(state.live)]
    if state.opens:
        tags.append(Tag(f"{state.opens} earlier clip shown", "caution"))
    if state.timeline.frozen_index is not None:
        tags.append(Tag(f"FROZEN · frame {state.timeline.frozen_index + 1}", "caution"))
    if tinted(state) is not None:
        tags.append(TINTED)
    if state.is_unreadable:
        tags.append(Tag(f"FRAME {state.timeline.shown_index + 1} CANNOT BE READ", "caution"))
    elif stale and not state.timeline.playing and state.window.now - state.picture.asked_at > STALE_SECONDS:
        tags.append(Tag("UPDATING…", "caution"))
        tags.extend(_first_use(state))
    return tuple(tags)


def _first_use(state: AppState) -> tuple[Tag, ...]:
    """Why it takes so long, where another method than the one on screen was asked for."""
    if (now := state.window.preparation) is not None and not state.pictures_are_stale:
        left = now.left(preset_of(state.enhancement.params))
        return (Tag(f"One-time preparation of this method: {left}"),)
    shown, wanted = state.picture.pictures, state.picture_request
    if shown is None or wanted is None or state.window.now - state.picture.asked_at <= LONG_SECONDS:
        return ()
    same = shown.enhanced is not None and type(shown.request.params) is type(wanted.params)
    return () if same else (Tag(FIRST_USE),)


def hides_enhancement(state: AppState, scene: Scene) -> bool:
    """Only frames as recorded are to be seen, and this model was trained on others."""
    plain = state.enhancement.peeking or not state.enhancement.active
    return plain and scene.record.input not in (None, ORIGINAL)


def frame_share(state: AppState, scene: Scene) -> float:
    """Of the frame over a snapped view: all of it where the model would show its enhancement."""
    return 1.0 if hides_enhancement(state, scene) else state.scene.viewer.blend


def tinted(state: AppState) -> BoolImage | None:
    """(H, W), True where the pictures on screen are to be tinted as left out."""
    masked, drawn = state.picture.left_out, state.masking.shown
    if state.masking.active and drawn is not None and drawn.request.clip is state.masks_clip:
        return drawn.left_out if drawn.request.index == state.timeline.shown_index else None
    if not state.picture.overlay or masked is None or masked.request.clip is not state.source.clip:
        return None
    return masked.pixels if masked.request.frame_index == state.timeline.shown_index else None


def difference_request(state: AppState) -> DifferenceRequest | None:
    """The two pictures whose difference is to be shown; None in other modes, or where they have two sizes."""
    if state.picture.pictures is None or shown_mode(state) != "difference":
        return None
    left, right = (pane(state, state.picture.pictures, side).image for side in SIDES)
    return DifferenceRequest(left, right, state.source.clip) if left.shape == right.shape else None


def difference_pane(left: Pane, right: Pane, difference: Difference) -> Pane:
    """The heat map, with both names; its colours, of a scale, are neither clipped nor tinted."""
    names = f"{left.tags[0].text} − {right.tags[0].text}"
    said = Tag(f"largest of R, G, B · mean {difference.mean:.1f} grey levels")
    stale = left.stale or right.stale or difference.request != DifferenceRequest(left.image, right.image)
    others = [tag for tag in cautions(right.tags[1:]) if tag != TINTED]
    return Pane(difference.heat, (Tag(f"DIFFERENCE · {names}", "caution"), said, *others), stale)


@dataclass(frozen=True)
class Pixel:
    """One pixel of a picture in grey levels, with its V and S of HSV."""

    rgb: tuple[int, int, int]

    @property
    def value(self) -> int:
        """V, 0 to 255."""
        return max(self.rgb)

    @property
    def saturation(self) -> float:
        """S in [0, 1]; 0 at black."""
        return (self.value - min(self.rgb)) / self.value if self.value else 0.0

    @property
    def color(self) -> str:
        red, green, blue = self.rgb
        return f"RGB {red:3d} {green:3d} {blue:3d}"

    def __str__(self) -> str:
        return f"{self.color}   V {self.value:3d}   S {self.saturation:.2f}"


def pixel(image: ByteImage, at: tuple[int, int]) -> Pixel | None:
    """The pixel in column and row `at`; None outside the picture."""
    x, y = at
    if not (0 <= y < image.shape[0] and 0 <= x < image.shape[1]):
        return None
    red, green, blue = np.asarray(image[y, x]).tolist()
    return Pixel((red, green, blue))


def faint_vessels(state: AppState) -> VesselsSeen | None:
    """Of the frame on screen, where the enhancement that is shown makes vessels fainter than they were, or
    where the paper's method in full strength makes them hardly clearer."""
    seen, pictures, params = state.measured, state.picture.pictures, state.enhancement.params
    shown = {state.comparing.chosen.source(side) for side in SIDES}
    if seen is None or pictures is None or ENHANCED not in shown or not state.enhancement.active:
        return None
    if seen.pictures is not pictures or pictures.request.params != params or seen.vessels is None:
        return None
    in_full = isinstance(params, EnhanceParams) and params.strength >= 1
    found = seen.vessels
    return found if found.are_fainter or (in_full and found.are_hardly_clearer) else None
