"""The app's one window: its panels, how they are laid out, and what connects them."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import moderngl
from imgui_bundle import hello_imgui, imgui, immapp

from app.console.ending import noted
from app.console.log_file import logged
from app.enhancement.methods import preset_of
from app.errors import UserError
from app.files.provenance import version
from app.gui.actions import (
    actions,
    batch_actions,
    enhancement_actions,
    live_actions,
    presenting,
    preset_actions,
    queue_actions,
    recovering,
    remembered,
    window_actions,
)
from app.gui.commands.command import Section, WindowServices
from app.gui.commands.commands import sections
from app.gui.commands.keys import Keyboard
from app.gui.drawing.textures import Textures
from app.gui.frame import dockings, starting
from app.gui.frame.canvas import Canvas
from app.gui.frame.density import Density
from app.gui.frame.dialogs import Dialogs
from app.gui.frame.dockings import MASKS, REPORT, SPLATS, TUNING, panel
from app.gui.frame.quitting import ask_before_quitting
from app.gui.frame.screen import Screen
from app.gui.frame.title import Title
from app.gui.frame.window_shots import shoot_window
from app.gui.panels import menus, overlays
from app.gui.panels.about import draw_about
from app.gui.panels.batches import draw_batches
from app.gui.panels.cameras import draw_cameras
from app.gui.panels.compare import draw_compare
from app.gui.panels.editing import PANEL, draw_edit_question, draw_edit_tools, draw_editing
from app.gui.panels.enhancement import draw_enhancement
from app.gui.panels.export import draw_export
from app.gui.panels.file_browser import draw_browser
from app.gui.panels.guide import draw_guide
from app.gui.panels.live import draw_live_choice
from app.gui.panels.masking import draw_masking, draw_masking_question
from app.gui.panels.palette import draw_palette
from app.gui.panels.presentation import draw_presentation
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.panels.report import draw_report
from app.gui.panels.run_questions import draw_run_question
from app.gui.panels.runs import draw_runs
from app.gui.panels.summary import draw_summary
from app.gui.panels.timeline import draw_timeline
from app.gui.panels.tuning import draw_tuning
from app.gui.panels.view3d import draw_view3d
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.style import fonts, theme
from app.gui.update.channels import Channels
from app.gui.update.jobs import MakeJob, start_due
from app.gui.update.live import close_live, follow_live, shown
from app.gui.update.preparing import follow_preparation
from app.gui.update.update import take_pictures, update
from app.gui.work import kept_layout, tidying
from app.gui.work.background import Apart, Worker, leave
from app.gui.work.settings import Places, Theme, load_clips, load_settings
from app.kernels.preparer import Preparer
from app.kernels.progress import Kind
from app.kernels.stamp import is_prepared
from app.live.session import LiveSession
from app.live.start import LiveStart
from app.runs.job import TrainingJob
from app.runs.memory import share_memory
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.splat_files import SUFFIXES as SPLAT_FILES

IDLE_FPS = 1.0
"""Events and finished work wake the window at once; a software driver pays some 30 ms for each frame."""
BUSY_FPS = 25.0
"""While something runs in the background that the window should follow."""
ACTIVE, ACTIVE_LIVE = 1.0, 0.05
"""Seconds of frames without pause after each event."""
RUNNER = WindowServices(dockings.restore, dockings.quit_app, dockings.toggle, dockings.is_shown)


def run_app(
    paths: Sequence[Path] = (), clip_options: ClipOptions = DEFAULTS, live: LiveStart | None = None
) -> None:
    """Open the window, on a clip, a run or a live source if given, and return when it is closed; of several
    paths on the first.

    `clip_options` are for all clips that are opened in it; a run keeps those it was begun with.

    Raises:
        UserError: there is no screen, or no OpenGL 3.3 on it.
    """
    places = Places.of_user()
    window = Window(AppState(places, load_settings(places.settings_file), Source(clip_options)))
    remembered.begin(window.state)
    if not is_prepared():
        seen: tuple[Kind, ...] = ("3D view",) if paths and paths[0].suffix.lower() in SPLAT_FILES else ()
        window.prepare(Preparer(*seen, preset_of(window.state.enhancement.params)))
    recovering.offer_recovery(window.state)
    if paths:
        actions.open_first(window.state, paths)
    elif live is not None:
        live_actions.begin(window.state, live)
    with logged(
        places.logs, f"VesselSplat {version()}, {platform.platform()}, Python {platform.python_version()}"
    ):
        window.run()
    leave(window._workers)


class Window:
    """What outlives a frame: the state, the background work, and the OpenGL objects.

    `make_job` starts reconstructions; tests put a fake in its place.
    """

    def __init__(self, state: AppState, make_job: MakeJob = TrainingJob) -> None:
        share_memory()
        self.state = state
        preset_actions.load(state)
        queue_actions.take_up(state)
        state.source.known = load_clips(state.places.config)
        self._make_job = make_job
        self._channels = Channels()
        self._workers: tuple[Worker | Apart, ...] = (
            Worker(self._channels.of("first"), hello_imgui.request_refresh, tidying.rest),
            Worker(self._channels.of("second"), hello_imgui.request_refresh, tidying.rest),
            Worker(self._channels.of("third"), hello_imgui.request_refresh, tidying.rest),
            *(Apart(channel, hello_imgui.request_refresh) for channel in self._channels.of("apart")),
        )
        self._preparer: Preparer | None = None
        self._dialogs, self._title = Dialogs(), Title()
        self._screen, self._density = Screen(self._add_timeline), Density()
        self._commands: tuple[Section, ...] = ()
        self._keyboard = Keyboard()
        self._canvas: Canvas | None = None
        self._worn: tuple[Theme, int] | None = None
        self._size, self._upright, self._filled = (0, 0), False, (0, 0)
        self._dropped: list[str] = []
        self._has_signal: Callable[[], bool] = lambda: False
        """Whoever sends one cannot be asked: what is unsaved is offered at the next start."""
        self._began = time.monotonic()

    def prepare(self, preparer: Preparer) -> None:
        """Let it compile meanwhile what is not yet compiled."""
        self._preparer = preparer
        preparer.start()
        follow_preparation(self.state, preparer)

    def run(self) -> None:
        """Return when the window is closed. Raises UserError when it cannot be opened."""
        try:
            with noted() as self._has_signal:
                immapp.run(self.runner_params(), self.add_ons())
                # Before a signal that has closed the window takes its course.
                kept_layout.seal(self._layout_file)
        except (RuntimeError, moderngl.Error) as error:
            if self._canvas is not None:
                raise
            raise UserError(starting.why_none_opens(error)) from error
        finally:
            self._end_work()

    def runner_params(self) -> hello_imgui.RunnerParams:
        """Everything the runner needs; the test engine takes the same."""
        params = starting.runner(self._layout_file, readable=self._has_sound_layout())
        params.fps_idling.fps_idle = IDLE_FPS
        params.docking_params, *params.alternative_docking_layouts = dockings.layouts(self._layout)
        params.remember_selected_alternative_layout = False
        self._connect(params)
        return params

    @property
    def _layout_file(self) -> Path:
        return self.state.places.config / kept_layout.NAME

    def _has_sound_layout(self) -> bool:
        """Whether the runner may read the layout on disk, and write it."""
        if not starting.can_hold_files(self.state.places.config):
            return False
        try:
            damage = kept_layout.put_aside_damaged(self._layout_file)
        except OSError as error:
            actions.say(self.state, f"the window layout cannot be saved: {error}")
            return False
        if damage:
            actions.say(self.state, damage)
        return True

    @staticmethod
    def add_ons() -> immapp.AddOnsParams:
        return immapp.AddOnsParams(with_implot=True)

    def _connect(self, params: hello_imgui.RunnerParams) -> None:
        calls = params.callbacks
        calls.load_additional_fonts = fonts.load_fonts
        calls.setup_imgui_style = theme.apply_style
        calls.setup_imgui_config = partial(starting.configure, self._layout_file)
        calls.post_init = self._begin
        calls.pre_new_frame = self._advance
        calls.post_new_frame = self._keyboard.walk.follow
        calls.show_menus = lambda: menus.draw_menus(self.state, self._commands)
        calls.show_status = lambda: menus.draw_status(self.state)
        calls.post_render_dockable_windows = self._draw_over
        calls.before_swap = self._end_frame
        calls.after_swap = partial(shown, self.state)
        calls.before_exit = self.close
        self._add_timeline(params)

    def _add_timeline(self, params: hello_imgui.RunnerParams) -> None:
        """Again for every theme: the runner keeps the colour behind it."""
        ground = theme.THEMES[self.state.settings.theme].shade(0.11)
        params.callbacks.add_edge_toolbar(
            hello_imgui.EdgeToolbarType.bottom,
            lambda: self._draw_textured(draw_timeline),
            hello_imgui.EdgeToolbarOptions(size_em=5.4, window_padding_em=(0.6, 0.5), window_bg=ground),
        )

    def _layout(self) -> hello_imgui.DockingParams:
        #  ______________________________
        # | images           | enhance   |
        # |__________________|___________|
        # | 3D view          | recon-    |
        # |__________________|_struct____|
        layout = hello_imgui.DockingParams()
        layout.main_dock_space_node_flags = imgui.DockNodeFlags_.none
        layout.dockable_windows = [
            # Before the pictures, which show in the same frame what has moved here.
            panel("Enhancement", "Side", lambda: self._draw_textured(draw_enhancement)),
            panel("Images", "MainDockSpace", self._draw_pictures),
            panel("3D view", "Below", self._draw_view),
            panel(SPLATS, "MainDockSpace", self._draw_view, "by the state"),
            panel("Reconstruction", "SideBelow", lambda: draw_reconstruction(self.state)),
            panel("Runs", "SideBelow", lambda: draw_runs(self.state)),
            panel("Cameras", "SideBelow", lambda: draw_cameras(self.state)),
            panel(
                "Log", "Below", lambda: overlays.draw_log(self.state, imgui.set_clipboard_text), "by the menu"
            ),
            panel("Notes", "Below", lambda: overlays.draw_notes(self.state), "by the menu"),
            panel(REPORT, "MainDockSpace", lambda: self._draw_textured(draw_report), "by the menu"),
            panel(TUNING, "MainDockSpace", lambda: self._draw_textured(draw_tuning), "by the state"),
            panel(PANEL, "Side", lambda: draw_editing(self.state), "by the state"),
            panel(MASKS, "Side", lambda: draw_masking(self.state), "by the state"),
        ]
        return layout

    def _begin(self) -> None:
        """The OpenGL context is there."""
        self._canvas = Canvas.of(self.state)
        starting.connect(self.drop)

    @property
    def canvas(self) -> Canvas:
        """From the first frame on."""
        assert self._canvas is not None
        return self._canvas

    def _advance(self) -> None:
        """Before each frame: news from the background, what can be done, how soon the next is wanted."""
        if self._dropped:
            batch_actions.take_dropped(self.state, [Path(text) for text in self._dropped])
            self._dropped = []
        follow_preparation(self.state, self._preparer)
        follow_live(self.state, _session)
        update(self.state, self._channels, time.monotonic() - self._began)
        if not self._has_signal():
            # Training may have ended by the same one: what waits is kept for the next start.
            start_due(self.state, self._make_job)
        self._commands = sections(self.state, RUNNER)
        params = hello_imgui.get_runner_params()
        self._wear(params)
        self._screen.follow(self.state, params)
        presenting.begin_frame(self.state)
        dockings.follow(self.state)
        self._title.follow(self.state)
        dockings.spare_ground()
        idling = params.fps_idling
        idling.enable_idling = not self.state.moves
        idling.fps_idle = BUSY_FPS if self.state.is_busy else IDLE_FPS
        # Live pictures wake the window; frames between them would take their time on the processor.
        idling.time_active_after_last_event = ACTIVE_LIVE if self.state.live.flows else ACTIVE

    def _wear(self, params: hello_imgui.RunnerParams) -> None:
        """The theme and the size of text that are chosen; and where panels are after a reset."""
        settings = self.state.settings
        chosen = settings.theme, round(self._density.follow() * settings.text_percent)
        size = dockings.window_size(first=self._worn is None)
        if (size, chosen) != (self._size, self._worn):
            dockings.arrange(params, size, chosen[1])
        # What fills the screen for a while turns nothing, also while it is not yet as small as before.
        lasts = size == self._filled or self.state.window.full_screen
        stays = lasts or window_actions.is_reduced(self.state)
        upright = self._upright if stays else dockings.is_upright(size)
        if self._worn is not None and upright != self._upright:
            dockings.restore_all()
        self._size, self._upright, self._filled = size, upright, size if lasts else (0, 0)
        if self._worn == chosen:
            return
        before = self._worn or chosen
        if dockings.tabs(size, before[1]) != dockings.tabs(size, chosen[1]):
            dockings.restore_all()
        elif self._worn is not None:
            # What is kept of the layout already has the width for the text at the start.
            dockings.widen(self._worn[1], chosen[1], upright=upright)
        # What is there in the first frame is scaled by the runner, after it.
        density = 1.0 if self._worn is None else hello_imgui.dpi_window_size_factor()
        self._worn = chosen
        theme.wear(*chosen, density)
        self._add_timeline(params)

    def _draw_pictures(self) -> None:
        take_pictures(self.state, self._channels)
        self._draw_textured(draw_compare)

    def _draw_textured(self, draw: Callable[[AppState, Textures], None]) -> None:
        draw(self.state, self.canvas.textures)

    def _draw_view(self) -> None:
        canvas = self.canvas
        draw_view3d(self.state, canvas.viewport, canvas.second_viewport, canvas.textures)
        if self.state.scene.model is not None:
            draw_edit_tools(self.state)

    def _end_frame(self) -> None:
        """All is drawn and not yet shown."""
        shoot_window(self.canvas.ctx, self.state)
        self.canvas.second_window.follow(self.state)

    def _draw_over(self) -> None:
        draw_presentation(self.state, self.canvas.textures, self.canvas.backdrop, self.canvas.viewport)
        overlays.draw_banner(self.state)
        overlays.draw_toast(self.state)
        overlays.draw_help(self.state, self._commands)
        draw_edit_question(self.state)
        draw_run_question(self.state)
        draw_masking_question(self.state)
        overlays.draw_notice(self.state)
        draw_export(self.state)
        draw_batches(self.state)
        self._draw_textured(draw_summary)
        self._draw_textured(draw_guide)
        draw_about(self.state, imgui.set_clipboard_text)
        self._draw_textured(draw_live_choice)
        overlays.draw_recovery(self.state)
        self._dialogs.follow(self.state)
        self._draw_textured(draw_browser)
        draw_palette(self.state, self._commands)
        self._keyboard.handle(self.state, self._commands)
        ask_before_quitting(self.state)
        if self._has_signal():
            dockings.quit_app()
        self._screen.end_whole(self.state)
        if not imgui.is_any_item_active():
            enhancement_actions.settle_params(self.state)
            remembered.remember(self.state)

    def close(self) -> None:
        """While OpenGL is still there: end the background work and give everything back."""
        self._end_work()
        if not self._has_signal():
            recovering.end(self.state)
        queue_actions.keep_now(self.state)
        if self._canvas is not None:
            self._canvas.release()

    def _end_work(self) -> None:
        """Also of a window that a signal ends: what the job shares would be left in memory."""
        runs = self.state.runs
        if runs.reconstruction.job is not None:
            runs.reconstruction.job.close()
        if runs.ending is not None:
            runs.ending.job.close()
        runs.reconstruction.job = runs.ending = None
        close_live(self.state)
        if self._preparer is not None:
            self._preparer.close()
        for worker in self._workers:
            worker.close()
        self._channels.finish(self.state)

    def drop(self, window: object, paths: list[str]) -> None:
        """Files were dropped on the window: they are looked at with the next frame."""
        self._dropped = paths


_session = partial(LiveSession, on_picture=hello_imgui.request_refresh)
