"""What answers of the background work change in the state, where no action does that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from app.enhancement.clip_statistics import ClipStatistics, StatisticsRequest
from app.enhancement.frame_enhancer import Pictures
from app.exports.comparison_images import Difference, DifferenceRequest, Other, OtherRequest
from app.files.legible import located
from app.gui.actions import (
    actions,
    arriving,
    clip_actions,
    path_actions,
    second_actions,
    session_actions,
    summary_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.panes import other_request
from app.gui.state.scene import Viewed
from app.gui.views.comparison import Side
from app.gui.work.background import Answer, Failure, Request
from app.gui.work.baking import Baked, BakeRequest
from app.gui.work.clip_scale import ClipScale, ScaleRequest
from app.gui.work.masking import LeftOut, LeftOutRequest
from app.gui.work.measuring import Measured
from app.gui.work.neighbours import Neighbours, NeighboursRequest
from app.gui.work.omissions import Looking, Omissions, OmissionsRequest
from app.gui.work.opening import Opened, OpenRequest, SourceLost
from app.gui.work.recents import Recent, RecentsRequest
from app.gui.work.run_measures import RunMeasures, RunMeasuresRequest
from app.gui.work.strip import Strip, StripRequest
from app.gui.work.writing import WriteRequest
from app.scenes.drawer import View
from app.scenes.view_request import FrameImage, FrameRequest, ViewRequest
from renderer.clip import ByteImage

Take = Callable[[AppState, Request, Answer | Failure], None]


def told(
    trouble: str,
    take: Callable[[AppState, Request, Answer], None],
    tell: Callable[[AppState, str], None] = actions.fail,
) -> Take[Request, Answer]:
    """`take` for an answer; of a failure `tell` says `trouble` with its reason."""

    def either(state: AppState, request: Request, answer: Answer | Failure) -> None:
        if isinstance(answer, Failure):
            tell(state, f"{trouble}: {answer.message}")
        else:
            take(state, request, answer)

    return either


def noted(trouble: str, take: Callable[[AppState, Request, Answer], None]) -> Take[Request, Answer]:
    """As `told`, but a failure is a line of the log alone."""
    return told(trouble, take, actions.say)


def take_omissions(state: AppState, request: OmissionsRequest, answer: Looking | Omissions | Failure) -> None:
    match answer:
        case Looking():
            state.runs.looking = answer
        case Omissions():
            state.runs.omissions, state.runs.looking = answer, None
        case Failure():
            actions.fail(state, f"what will be left out cannot be determined: {answer.message}")


def take_frame(state: AppState, request: FrameRequest, frame_image: FrameImage) -> None:
    state.scene.viewer.frame_image = frame_image


def take_neighbours(state: AppState, request: NeighboursRequest, neighbours: Neighbours) -> None:
    state.source.neighbours = neighbours


def take_difference(state: AppState, request: DifferenceRequest, difference: Difference) -> None:
    """Of a clip that is no longer open, it is dropped."""
    if request.clip is state.source.clip:
        state.comparing.difference = difference


def take_statistics(
    state: AppState, request: StatisticsRequest, answer: ClipStatistics | Failure | None
) -> None:
    """A clip that cannot be measured, as a frame is damaged, has each frame enhanced by itself."""
    if isinstance(answer, Failure):
        actions.say(state, f"the statistics of the clip cannot be measured: {answer.message}")
        state.picture.of_clip = ClipStatistics(request, None)
    elif answer is not None:
        state.picture.of_clip = answer


def take_measured(state: AppState, request: Pictures, measured: Measured) -> None:
    """Of a clip that is no longer open, it is dropped."""
    if request.request.clip is state.source.clip:
        state.picture.measured = measured


def take_run_measures(state: AppState, request: RunMeasuresRequest, answer: RunMeasures | Failure) -> None:
    if isinstance(answer, Failure):
        actions.say(state, f"the run cannot be measured: {answer.message}")
        answer = RunMeasures(request, 0)
    state.runs.measures = answer


def take_strip(state: AppState, request: StripRequest, strip: Strip) -> None:
    state.timeline.strip = strip


def take_left_out(state: AppState, request: LeftOutRequest, left_out: LeftOut) -> None:
    state.picture.left_out = left_out


def take_view(state: AppState, request: ViewRequest, answer: View | Failure) -> None:
    """Of a model that is gone, it is dropped."""
    if state.scene.model is not None:
        _take_view(state, state.scene, "the 3D view", answer)


def take_second(state: AppState, request: ViewRequest, answer: View | Failure) -> None:
    """Of a model that is no longer beside the first, it is dropped."""
    if request.scene is state.scene.second.model:
        _take_view(state, state.scene.second, "the second 3D view", answer)


def _take_view(state: AppState, viewed: Viewed, name: str, answer: View | Failure) -> None:
    if isinstance(answer, Failure):
        actions.fail(state, f"{name} cannot be rendered: {answer.message}")
    else:
        viewed.view = answer


def take_opened(state: AppState, request: OpenRequest, answer: Opened | Failure) -> None:
    """Show it; what nobody waits for any longer is dropped."""
    if request is not state.source.opening:
        return
    state.source.opening = None
    if isinstance(answer, Failure):
        actions.fail(state, answer.message)
        if isinstance(answer.error, SourceLost):
            session_actions.offer_to_find(state, answer.error)
    elif answer.views is not None:
        path_actions.add_views(state, answer.views, request.path)
    elif state.runs.reconstruction.is_alive and answer.model is not None and answer.session is None:
        second_actions.show_instead(state, request.path, answer.model)
    elif answer.report is not None:
        arriving.show_opened(state, request.path, answer)
    else:
        # What has been changed meanwhile, while one could go on with what was open.
        session_actions.look_for_changes(state)
        leave = actions.leave if arriving.goes_on(state, answer) else actions.leave_session
        # The notes of a session take the place of those there are.
        leave = leave if answer.session is None else session_actions.leave_case
        leave(state, partial(_show_opened, state, request, answer))


def _show_opened(state: AppState, request: OpenRequest, answer: Opened) -> None:
    arriving.show_opened(state, request.path, answer)
    clip_actions.keep_lens(state, request)
    if answer.session is not None:
        summary_actions.restore(state, answer.session.summary, answer.pictures)
        session_actions.restore(state, answer.session, answer.second)
        session_actions.taken_up(state, answer, request.path)


def take_other(side: Side, state: AppState, request: OtherRequest, answer: Other | Failure) -> None:
    if not isinstance(answer, Failure):
        state.comparing.others[side] = answer
    elif request == other_request(state, side):
        state.timeline.playing = False
        actions.fail(state, f"the {side} pane cannot be shown: {answer.message}")


def take_scale(state: AppState, request: ScaleRequest, answer: ClipScale) -> None:
    state.scene.clip_scale = answer


def take_baked(state: AppState, request: BakeRequest, answer: Baked | Failure) -> None:
    _take_baked(state, state.scene, "the 3D view", request, answer)


def take_second_baked(state: AppState, request: BakeRequest, answer: Baked | Failure) -> None:
    _take_baked(state, state.scene.second, "the second 3D view", request, answer)


def _take_baked(
    state: AppState, viewed: Viewed, name: str, request: BakeRequest, answer: Baked | Failure
) -> None:
    """The next part; of a model that is no longer shown, it is dropped."""
    if request.shown is not viewed.model:
        return
    if isinstance(answer, Failure):
        actions.say(state, f"{name} has no keyframes: {answer.message}")
        return
    viewed.baked = answer
    if answer.said:
        actions.say(state, f"{name} {answer.said}")


def take_recents(state: AppState, request: RecentsRequest, recents: Mapping[str, Recent]) -> None:
    state.welcome.recents = recents


def take_welcome(state: AppState, request: Path, samples: Mapping[str, ByteImage]) -> None:
    state.welcome.samples = samples


def take_nothing(state: AppState, request: object, answer: object) -> None:
    """It has been done."""


def take_written(state: AppState, request: WriteRequest, answer: Path | Failure) -> None:
    """A file that was asked for is announced; of others only trouble is noted."""
    if isinstance(answer, Failure):
        tell = actions.fail if request.announced else actions.say
        tell(state, f"{request.trouble}: {answer.message}")
    elif request.announced:
        actions.announce(state, f"saved {answer.name} in {located(answer.parent)}")
