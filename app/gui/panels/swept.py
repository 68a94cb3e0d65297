"""The jobs of a sweep as points: any two measures against each other, one job's image and its settings."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TypeVar

from imgui_bundle import ImVec2, imgui, imgui_ctx, implot

from app.gui.actions import sweep_actions
from app.gui.drawing.textures import ShowsPictures
from app.gui.panels.tuning import draw_use
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import button, choose, em, muted
from app.gui.work.reported import plain
from app.gui.work.swept import Swept, SweptJob, in_words

P = TypeVar("P")
MARKERS = 10
"""Shapes of ImPlot, so that colour is not the only sign."""
NEAR = 0.75
"""Text heights from the pointer to a point that it names."""
MARGIN = 0.06
"""Of the axes, beyond the outermost points."""
TOLD = 8
"""Values of a job beside its image."""


def draw_swept(state: AppState, textures: ShowsPictures, sweep: Swept) -> None:
    """The axes, the points, and the job that was clicked."""
    across, up = state.reports.axes or sweep.first
    names = {name: in_words(name) for name in sweep.columns}
    imgui.align_text_to_frame_padding()
    muted("Up")
    imgui.same_line()
    new_up = choose("sweep up", up, names, "What the vertical axis is of.", 12)
    imgui.same_line()
    muted("Across")
    imgui.same_line()
    new_across = choose("sweep across", across, names, "What the horizontal axis is of.", 12)
    if (new_across, new_up) != (across, up):
        sweep_actions.choose_axes(state, new_across, new_up)
    size = ImVec2(-1, max(em(14), imgui.get_content_region_avail().y * 0.5))
    implot.push_style_var(implot.StyleVar_.fit_padding, ImVec2(MARGIN, MARGIN))
    if implot.begin_plot("##sweep", size, theme.PLOT):
        _plot(state, sweep, new_across, new_up)
        implot.end_plot()
    implot.pop_style_var()
    if state.reports.job is None:
        muted("Click a point: the job's image and settings.")
    else:
        _draw_job(state, textures, state.reports.job)


def _plot(state: AppState, sweep: Swept, across: str, up: str) -> None:
    flags = implot.AxisFlags_.auto_fit
    implot.setup_axes(in_words(across), in_words(up), flags, flags)
    if len(sweep.series) > 1:
        implot.setup_legend(implot.Location_.east, implot.LegendFlags_.outside)
    for place, name in enumerate(sweep.series):
        mark = implot.Spec(marker=place % MARKERS, marker_size=em(0.28))
        implot.plot_scatter(name, *sweep.places(name, across, up), mark)
    if (job := state.reports.job) is not None and across in job.values and up in job.values:
        ring(job.values[across], job.values[up])
    drawn = (job for job in sweep.jobs if across in job.values and up in job.values)
    if (near := nearest((job, (job.values[across], job.values[up])) for job in drawn)) is not None:
        told = [f"{in_words(axis)} {plain(near.values[axis], 4)}" for axis in (up, across)]
        imgui.set_tooltip("\n".join([near.clip, near.setting, *told]))
        if imgui.is_mouse_clicked(imgui.MouseButton_.left):
            sweep_actions.choose_job(state, near)


def ring(x: float, y: float, *, filled: bool = False) -> None:
    """Around what is chosen, at these values of the plot's axes; `filled`: where no point is drawn."""
    place, ink = implot.plot_to_pixels(x, y), imgui.get_color_u32(theme.now().accent)
    draw = implot.get_plot_draw_list()
    implot.push_plot_clip_rect()
    if filled:
        draw.add_circle_filled(place, em(0.38), ink)
    draw.add_circle(place, em(0.6), ink, 0, em(0.12))
    implot.pop_plot_clip_rect()


def nearest(places: Iterable[tuple[P, tuple[float, float]]]) -> P | None:
    """What is under the pointer, of points and where each is on the plot's axes."""
    if not implot.is_plot_hovered():
        return None
    mouse = imgui.get_mouse_pos()
    best, least = None, em(NEAR) ** 2
    for one, (x, y) in places:
        place = implot.plot_to_pixels(x, y)
        apart = (place.x - mouse.x) ** 2 + (place.y - mouse.y) ** 2
        if apart < least:
            best, least = one, apart
    return best


def _draw_job(state: AppState, textures: ShowsPictures, job: SweptJob) -> None:
    """Its image at the left, what it is and what can be done with it beside."""
    width = min(em(20), imgui.get_content_region_avail().x * 0.5)
    shown = state.reports.image
    if shown is not None and shown.job is job:
        down, across = shown.image.shape[:2]
        imgui.image(textures.whole("sweep job", shown.image), ImVec2(width, width * down / across))
        imgui.same_line(0, em(1))
    with imgui_ctx.begin_group(), imgui_ctx.push_text_wrap_pos(0):
        imgui.text_unformatted(job.clip)
        imgui.text_unformatted(job.setting)
        for name, value in list(job.values.items())[:TOLD]:
            muted(f"{in_words(name)} {plain(value, 4)}")
        if job.params is not None:
            draw_use(partial(sweep_actions.use_params, state, job))
        if job.run is not None:
            act = partial(sweep_actions.open_run, state, job)
            button("Open the reconstruction###sweep run", act, "In place of what is shown.", width=12)
