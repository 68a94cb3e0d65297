"""What to export, by what name and where, how large, how far it has come."""

from __future__ import annotations

from functools import partial

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.enhancement.image_mask import NO_MASK
from app.exports.sizing import LEAST_WIDTH, MOST_WIDTH, Sizing
from app.files.codecs import HEVC, WEBM
from app.files.dicom.choices import DicomChoices
from app.files.legible import legible, located
from app.gui.actions import actions, export_actions
from app.gui.actions.export_doubts import doubts
from app.gui.actions.export_lacks import lacks
from app.gui.actions.export_offers import GROUPS, OFFERS, Offer
from app.gui.actions.export_records import format_of
from app.gui.panels.overlays import covered, floating_window
from app.gui.state.app_state import AppState
from app.gui.state.exports import What
from app.gui.style import theme
from app.gui.style.handles import slide_labelled
from app.gui.style.widgets import (
    FLAT,
    button,
    choose,
    choose_row,
    em,
    end_of,
    explain,
    explain_entry,
    mark_row,
    muted,
    note,
    row,
)
from app.scenes.supersampling import FACTORS

OTHER_WIDTH, OTHER_SIZE = Sizing(width=1024), (1024, 1024)
SCALES = {Sizing(scale): f"{scale}×" for scale in (1, 2, 3, 4)} | {OTHER_WIDTH: "Width…"}
SCALE_TEXT = "File pixels per image pixel along each axis, or a width in pixels to resample to."
SIZES = ((1280, 720), (1920, 1080), (2560, 1440), (3840, 2160))
TITLE = "Export"
VIEW_SIZES: dict[tuple[int, int] | None, str] = {
    None: "As shown", **{size: f"{size[0]} × {size[1]}" for size in SIZES}, OTHER_SIZE: "Other…"
}  # fmt: skip
SAMPLINGS = {factor: "No supersampling" if factor == 1 else f"{factor}× supersampling" for factor in FACTORS}
VIEW_TEXT = (
    "Size of the 3D view in pixels. As shown: its shape on screen, at least as large as the clip's frames."
)
FACTOR_TEXT = (
    "Supersampling: rendered with this many times the pixels along each axis, then averaged. "
    "Smoother edges, slower."
)
QUALITY_TEXT = "Of 100: higher keeps more detail, in larger files."
DEGREES = {None: "As the model has", 3: "3, for the original viewer"}
HOLDING_SPLATS = ("splats", "splat folder", "moving splats")
KEPT = {True: "All Gaussians", False: "Without unobserved parts"}
KEPT_TEXT = (
    "Gaussians behind tissue in all frames are drawn only from where the endoscope was. Without them, holes "
    "are seen from there, at outlines; with them, blots from beside."
)
DEGREE_TEXT = (
    "Degree of the spherical harmonics, filled up with zeros: the original viewer of 3D Gaussian Splatting "
    "reads degree 3 only."
)
IDENTITIES = {False: "Left out", True: "As in the source"}
WHOLE_TEXT = "Made from the whole clip and all of its pixels: the trim and the masks drawn here do not count."
IDENTITY_TEXT = (
    "Patient, study and sound. As in the source: DICOM files only; archives then sort both together."
)
BURNED_IN: dict[bool | None, str] = {
    None: "As the source says, else maybe",
    True: "May identify the patient",
    False: "Does not identify the patient",
}
BURNED_IN_TEXT = "Images are not searched for names or dates burned into them: state whether there are any."
ENCODED = {
    WEBM: "Plays in browsers and needs no licence; some presentation programs do not play it.",
    HEVC: "The smallest files, for newer devices; slow to encode.",
}
NAME_TEXT = "Name of the file; an existing file is never replaced."
FOLDER_TEXT = "Choose another folder; it is remembered."
SHOW_TEXT = "Show the file in the system's file manager."
REPLAY = "Each file records how it was made: vesselsplat replay FILE reproduces it."
REPLAY_UNNAMED = (
    "The file records how it was made, but not the name of its source: "
    "vesselsplat replay FILE --source SOURCE reproduces it."
)
BURNED_IN_STAYS = "Names or dates burned into the image stay in it: look before you send it to others."
LIST = 11.5
"""Text heights across of the list of what can be exported."""


def draw_export(state: AppState) -> None:
    """A window of its own."""
    if not state.exports.shown:
        return
    # Not in a picture of the window that is about to be taken.
    alpha = 0.0 if state.exports.settling else imgui.get_style().alpha
    with (
        imgui_ctx.push_style_var(imgui.StyleVar_.alpha, alpha),
        floating_window(state, state.exports, TITLE, 46) as drawn,
    ):
        if not drawn:
            return
        height = _list_height(state)
        with imgui_ctx.begin_child("what", ImVec2(em(LIST), height), FLAT):
            _draw_list(state)
        imgui.same_line(0, em(1))
        with imgui_ctx.begin_child("how", ImVec2(0, height), FLAT):
            _draw_chosen(state)


def _list_height(state: AppState) -> float:
    """As many lines as there are, or as there is room for."""
    style = imgui.get_style()
    lines = len(OFFERS) * (imgui.get_text_line_height() + style.item_spacing.y)
    heads = len(GROUPS) * (
        imgui.get_text_line_height() + 2 * style.separator_text_padding.y + style.item_spacing.y
    )
    viewport = imgui.get_main_viewport()
    room = viewport.work_size.y - em(7) - covered(state, viewport.work_pos.y)
    return min(lines + heads + em(0.5), room)


def _draw_list(state: AppState) -> None:
    for title in GROUPS:
        imgui.separator_text(title)
        for what, offer in OFFERS.items():
            if offer.traits.group == title:
                _draw_offer(state, what, offer)


def _draw_offer(state: AppState, what: What, offer: Offer) -> None:
    """Quiet where something is lacking, which its tooltip and the right side say."""
    reason = lacks(state, offer)
    color = theme.now().muted if reason else theme.now().text
    with imgui_ctx.push_style_color(imgui.Col_.text, color):
        clicked, _ = imgui.selectable(f"{offer.label}###{what}", state.exports.what == what)
    if state.exports.what == what:
        mark_row()
    explain_entry(reason)
    if clicked:
        export_actions.choose_what(state, what)


def _draw_chosen(state: AppState) -> None:
    offer = OFFERS[state.exports.what]
    imgui.separator_text(f"{offer.traits.group}: {offer.within}")
    note(offer.text)
    if told := doubts(state):
        note(told, theme.now().warning)
    imgui.spacing()
    _draw_name(state)
    _draw_folder(state)
    if offer.traits.format_text:
        _draw_format(state, offer)
    if offer.sides and offer.form != "measures":
        _draw_picture_size(state)
    if offer.sees != "no" and offer.form != "cameras" and state.scene.model is not None:
        _draw_view_size(state)
    if offer.form in ("splats", "splat folder"):
        degree = choose_row("Harmonics", state.exports.sh_degree, DEGREES, DEGREE_TEXT, 14)
        export_actions.choose_degree(state, degree)
    if offer.form in HOLDING_SPLATS and state.scene.model is not None and state.scene.model.tells_shown:
        kept = choose_row("Unobserved", state.exports.unobserved, KEPT, KEPT_TEXT, 14)
        export_actions.choose_unobserved(state, kept)
    if offer.is_dicom:
        _draw_dicom(state)
    if offer.traits.group == "Video":
        _draw_encoder(state)
    imgui.spacing()
    _draw_progress(state)
    if offer.form != "cameras" and state.exports.what != "window":
        note(_replay_text(state, offer))
    if offer.form in ("picture", "panes video"):
        note(BURNED_IN_STAYS)
    _draw_last(state)


def _replay_text(state: AppState, offer: Offer) -> str:
    """Without patients, files that are named after them are not named in DICOM."""
    is_unnamed = offer.is_dicom and not state.exports.dicom.keep_identity
    return REPLAY_UNNAMED if is_unnamed else REPLAY


def _draw_name(state: AppState) -> None:
    suffix = export_actions.suffix_of(state) or "/"
    row("Name", NAME_TEXT)
    imgui.set_next_item_width(-imgui.calc_text_size(suffix).x - em(0.6))
    changed, name = imgui.input_text("##name", export_actions.stem_of(state))
    explain(NAME_TEXT)
    if changed:
        export_actions.type_name(state, name)
    imgui.same_line(0, em(0.2))
    muted(suffix)


def _draw_folder(state: AppState) -> None:
    row("Folder", FOLDER_TEXT)
    button("Change…###folder", partial(choose_folder, state), FOLDER_TEXT, width=5.5)
    imgui.same_line()
    folder = located(state.export_folder).rstrip("/")
    muted(end_of(legible(folder), imgui.get_content_region_avail().x))
    explain(legible(str(state.export_folder)))


def choose_folder(state: AppState) -> None:
    """Where exports go from now on."""
    actions.choose_path(state, "folder", purpose="export")


def _draw_format(state: AppState, offer: Offer) -> None:
    traits = offer.traits
    suffix = choose_row("Format", format_of(state, offer.form), traits.formats, traits.format_text, 14)
    export_actions.choose_format(state, offer.form, suffix)
    if suffix == ".jpg":
        imgui.same_line()
        imgui.set_next_item_width(em(8))
        _, quality = slide_labelled("##quality", state.exports.quality, 50, 100, "quality %.0f")
        explain(QUALITY_TEXT)
        export_actions.choose_quality(state, round(quality))


def _draw_picture_size(state: AppState) -> None:
    sizing = state.exports.sizing
    now = sizing if sizing.width is None else OTHER_WIDTH
    chosen = choose_row("Panes", now, SCALES, SCALE_TEXT, 8)
    if chosen != now:
        export_actions.choose_sizing(state, chosen)
    if state.exports.sizing.width is not None:
        imgui.same_line()
        width = _pixels("##width", state.exports.sizing.width, "Width of each pane, in pixels.")
        imgui.same_line()
        muted("pixels")
        export_actions.choose_sizing(state, Sizing(width=width))


def _draw_view_size(state: AppState) -> None:
    size = state.exports.view_size
    now = size if size in VIEW_SIZES else OTHER_SIZE
    chosen = choose_row("3D view", now, VIEW_SIZES, VIEW_TEXT, 8)
    if chosen != now:
        export_actions.choose_view_size(state, chosen)
    elif now == OTHER_SIZE and size is not None:
        imgui.same_line()
        width = _pixels("##view width", size[0], "Width in pixels.")
        imgui.same_line()
        imgui.text("×")
        imgui.same_line()
        height = _pixels("##view height", size[1], "Height in pixels.")
        export_actions.choose_view_size(state, (width, height))
    row("", "")
    factor = choose("supersampling", state.exports.supersampling, SAMPLINGS, FACTOR_TEXT, 11)
    export_actions.choose_supersampling(state, factor)


def _pixels(label: str, value: int, text: str) -> int:
    """A number of pixels that is typed; half-typed ones do not count."""
    imgui.set_next_item_width(em(5))
    _, typed = imgui.input_int(label, value, 0, 0)
    explain(text)
    return min(max(typed, LEAST_WIDTH), MOST_WIDTH)


def _draw_dicom(state: AppState) -> None:
    choices = state.exports.dicom
    keep = choose_row("Patient", choices.keep_identity, IDENTITIES, IDENTITY_TEXT, 14)
    burned_in = choose_row("Burned-in", choices.burned_in, BURNED_IN, BURNED_IN_TEXT, 14)
    export_actions.choose_dicom(state, DicomChoices(keep_identity=keep, burned_in=burned_in))
    part = state.source.part
    if part.trim is not None or part.mask != NO_MASK:
        note(f"{icons.ICON_FA_EXCLAMATION_TRIANGLE}  {WHOLE_TEXT}", theme.now().warning)


def _draw_encoder(state: AppState) -> None:
    """Before a video is made: who can play it, and what helps."""
    encoder, suffix = state.exports.encoder, format_of(state, OFFERS[state.exports.what].form)
    if suffix in ENCODED:
        row("Video", "What this format is for.")
        note(ENCODED[suffix])
        return
    if encoder is None:
        note("Looking for a video encoder…")
        return
    row("Video", "What encodes the video on this computer.")
    if encoder.plays_in_browsers:
        note(encoder.said)
    else:
        note(f"{icons.ICON_FA_EXCLAMATION_TRIANGLE}  {encoder.said} {encoder.way_out}", theme.now().warning)


def _draw_progress(state: AppState) -> None:
    under_way = state.exports.under_way
    if under_way is None:
        reason, color = export_actions.why_not_start(state), theme.now().lit
        button(
            "Export###start",
            partial(export_actions.start, state),
            reason=reason,
            color=color,
            width=10,
        )
        if said := reason or _other_name(state):
            imgui.same_line()
            note(said)
        return
    total, done = max(under_way.steps, 1), state.exports.done
    # Not where Export stood: the second click of a double click would cancel.
    imgui.progress_bar(done / total, ImVec2(-em(7), 0), state.exports.pace.told(total))
    imgui.same_line()
    button("Cancel", partial(export_actions.cancelled, state), "No file is left incomplete.", width=6)
    # Another kind may have been chosen meanwhile.
    note(f"Writing {legible(export_actions.name_written(state))}")


def _other_name(state: AppState) -> str:
    """Beside the button, which stays where it is."""
    added = export_actions.added_to_name(state)
    return f"This name exists: {added} is added." if added else ""


def _draw_last(state: AppState) -> None:
    """What was written, and the way to it; or why nothing was."""
    if state.exports.failure:
        imgui.spacing()
        note(f"Not saved: {legible(state.exports.failure)}", theme.now().danger)
    if state.exports.last is None or state.exports.under_way is not None:
        return
    imgui.spacing()
    note(f"Saved {legible(state.exports.last.name)}")
    button("Show in folder###reveal", partial(export_actions.reveal, state), SHOW_TEXT, width=10)
