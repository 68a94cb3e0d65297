"""The menu bar and the status bar."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate, groupby

from imgui_bundle import imgui, imgui_ctx

from app.files.legible import in_one_line, legible
from app.files.provenance import NOTICE
from app.gui.commands.command import Command, Section
from app.gui.panels.overlays import LONG_NOTICE
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import em, explain, explain_entry, muted, shortened
from app.gui.views.key_words import with_keys
from app.kernels.progress import worded

MORE = "More"
SEPARATOR = "   ·   "
LEAST = 6.0
"""Text heights across below which a part of a fact tells nothing."""


def draw_menus(state: AppState, sections: tuple[Section, ...]) -> None:
    """Every command, for those who look rather than remember."""
    _hide_border(imgui.Col_.menu_bar_bg)
    menus = {name: tuple(grouped) for name, grouped in groupby(sections, lambda section: section.menu)}
    names = list(menus)
    whole = _how_many(names, imgui.get_content_region_avail().x)
    _draw_menus(state, {name: menus[name] for name in names[:whole]})
    if whole < len(names):
        with imgui_ctx.begin_menu(MORE) as more:
            if more:
                _draw_menus(state, {name: menus[name] for name in names[whole:]})


def _how_many(names: list[str], room: float) -> int:
    """Of the menus, those that fit into the bar; where not all do, with MORE behind them."""
    gaps = 2 * imgui.get_style().item_spacing.x
    ends = list(accumulate(imgui.calc_text_size(name).x + gaps for name in names))
    rest = 0.0 if ends[-1] <= room else imgui.calc_text_size(MORE).x + gaps
    return sum(end + rest <= room for end in ends)


def _draw_menus(state: AppState, menus: Mapping[str, tuple[Section, ...]]) -> None:
    for name, together in menus.items():
        with imgui_ctx.begin_menu(name) as menu:
            if menu:
                _draw_menu(state, together)


def _draw_menu(state: AppState, sections: tuple[Section, ...]) -> None:
    """A line between two sections; a submenu belongs to the section before it."""
    for place, section in enumerate(sections):
        if section.submenu:
            enabled = any(command.applies(state) for command in section.commands)
            with imgui_ctx.begin_menu(section.submenu, enabled) as menu:
                if menu:
                    draw_commands(state, section.commands)
            continue
        if place > 0:
            imgui.separator()
        draw_commands(state, section.commands)


def draw_commands(state: AppState, commands: tuple[Command, ...]) -> None:
    """One entry each; those that do not apply are greyed."""
    for command in commands:
        keys = with_keys(command.keys[0]) if command.keys else ""
        if imgui.menu_item_simple(command.label, keys, command.ticked(state), command.applies(state)):
            command.act(state)
        explain_entry(command.tooltip(state))


def draw_status(state: AppState) -> None:
    """The notice on the left, always; what is open and how fast things are on the right."""
    _hide_border(imgui.Col_.window_bg)
    width = imgui.get_window_width()
    notice = LONG_NOTICE if imgui.calc_text_size(LONG_NOTICE).x < width - em(1) else NOTICE
    imgui.text_colored(theme.now().warning, notice)
    room = width - imgui.calc_text_size(notice).x - em(4)
    if text := fitting(_facts(state), room):
        imgui.same_line(width - imgui.calc_text_size(text).x - em(1))
        muted(text)
        if state.scene.model is not None:
            explain(state.scene.drawn_by)


def fitting(facts: list[str], room: float) -> str:
    """As many as there is room for, the first ones first; of the first, if need be, both ends."""
    lines = (SEPARATOR.join(facts[:count]) for count in range(len(facts), 0, -1))
    whole = (line for line in lines if imgui.calc_text_size(line).x < room)
    return next(whole, shortened(facts[0], room) if facts and room > em(LEAST) else "")


def _hide_border(ground: imgui.Col_) -> None:
    """The runner's bars have every window's border, which at the edge of the screen is a line too many."""
    low, style = imgui.get_window_pos(), imgui.get_style()
    high, ink = low + imgui.get_window_size(), imgui.get_color_u32(style.color_(ground))
    with imgui_ctx.push_clip_rect(low, high, False):
        imgui.get_window_draw_list().add_rect(low, high, ink, thickness=style.window_border_size)


def _facts(state: AppState) -> list[str]:
    facts = []
    if (now := state.window.preparation) is not None:
        facts.append(worded(now))
    facts += _behind_closed_panels(state)
    if state.opens:
        return [*facts, state.opens]
    if state.source.clip is not None:
        camera = state.source.clip.cameras[state.timeline.shown_index]
        width, height = camera.width, camera.height
        facts.append(f"{in_one_line(state.source.clip.name)}  {width}×{height}")
    if state.session.is_unsaved and state.session.path is not None:
        facts.append(f"unsaved changes in {legible(state.session.path.name)}")
    if state.picture.pictures is not None and state.picture.pictures.enhanced is not None:
        facts.append(f"enhanced in {_while(state.picture.pictures.milliseconds)}")
    if state.scene.model is not None and not state.scene.processor_draws:
        facts.append("3D rendered with OpenGL")
    elif state.scene.model is not None:
        took = f" in {_while(state.scene.view.milliseconds)}" if state.scene.view else ""
        facts.append(f"3D rendered on the CPU{took}")
    return facts


def _behind_closed_panels(state: AppState) -> list[str]:
    """How far an export and a batch are that go on."""
    facts, export, batches = [], state.exports.under_way, state.batches
    if export is not None and not state.exports.shown:
        facts.append(f"Export: {state.exports.pace.told(max(export.steps, 1))}")
    if batches.under_way is not None and not batches.shown:
        step = batches.progressed.step if batches.progressed is not None else None
        facts.append(f"Files enhanced: {step.place} of {step.count}" if step else "Looking for images…")
    return facts


def _while(milliseconds: float) -> str:
    return f"{milliseconds:.0f} ms" if milliseconds < 1000 else f"{milliseconds / 1000:.1f} s"
