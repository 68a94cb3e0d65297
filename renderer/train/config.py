"""What a training run is asked to do. Rates are relative to the scene, so that units do not matter."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from annotated_types import Interval
from pydantic import AfterValidator, ConfigDict
from pydantic.dataclasses import dataclass

from renderer.splats import RenderMode

Method = Literal["vesselsplat", "deform3dgs", "endogaussian", "static"]

Part = Literal[
    "harmonics",
    "deformation",
    "color_curves",
    "controls",
    "moments",
    "depth",
    "masks",
    "tiles",
    "unseen",
    "hidden",
    "beside_tools",
    "surround",
    "tools",
    "poses",
    "exposure",
]
"""What a clip may not need; surround, tools, poses and exposure are decided on before training sees the
frames."""

EachOnce: Final = AfterValidator(lambda parts: tuple(sorted(set(parts))))
"""However often and in whatever order parts are named, the same is asked for."""

CHOSEN: Final = (
    "depth_weight, color_motion_rate and scale_rate were chosen on training frames of the pulling clip "
    "that were held out of the fit (hold_out); rate_decay, how far rates of positions fall, the mean over "
    "the last quarter of the steps, the start from tracks and n_controls on those of pulling, mesentery and "
    "phantom. The other numbers of "
    "vesselsplat come from trials with an earlier program, about 30 runs on the pulling clip, chosen by "
    "hand with its test frames in view: figures on that clip's test frames are optimistic by an unknown "
    "amount. Rates of deform3dgs and endogaussian are the published ones, but for the departures"
)
"""What the defaults were chosen on."""


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class TrainConfig:
    """One run of training. Lengths are fractions of the scene size, the median depth of the tissue.

    What the defaults were chosen on: CHOSEN.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range, or a part both kept and left out.

    Example:
        >>> from renderer import TrainConfig
        >>> TrainConfig(method="deform3dgs", iterations=1000).n_gaussians
        30000
    """

    method: Method = "vesselsplat"
    """vesselsplat: tissue moves by a shared-knot B-spline in time; deform3dgs: by bumps in time;
    endogaussian: by a HexPlane over space and time; static: nothing moves."""
    iterations: Annotated[int, Interval(ge=1, le=100_000)] = 3000
    """Training iterations, each on one frame, for each window of a long clip; endogaussian first takes a
    third as many more, in which nothing moves, and counts them too."""
    seed: Annotated[int, Interval(ge=0, le=2**31 - 1)] = 0
    """Random seed of the sampled points and the order of the frames."""
    n_gaussians: Annotated[int, Interval(ge=1, le=1_000_000)] = 30_000
    """Gaussians sampled from the depth of the training frames; fewer are faster but less sharp."""
    window_frames: Annotated[int, Interval(ge=48, le=100_000)] | None = None
    """About how many frames one set of Gaussians is trained on; longer clips are cut into windows, if
    they have at least 80; auto: 400, fewer where the camera travels."""
    n_controls: Annotated[int, Interval(ge=4, le=1000)] | None = None
    """Control values in time; empty: one per 3.7 frames, up to one per 2.3 where tracks show faster motion.
    More follow faster motion and overfit sooner."""
    node_columns: Annotated[int, Interval(ge=2, le=200)] = 20
    """Number of motion nodes across the view, shared by neighbouring Gaussians."""
    half_resolution_share: Annotated[float, Interval(ge=0, le=1)] = 1 / 3
    """Share of the steps, at the start, that train at half resolution."""
    initial_spacing: Annotated[float, Interval(ge=0.05, le=5)] = 0.8
    """Initial standard deviation of a Gaussian, as a multiple of the mean distance to its neighbours."""
    initial_opacity: Annotated[float, Interval(ge=0.01, le=0.99)] = 0.9
    """Initial opacity of every Gaussian."""
    depth_weight: Annotated[float, Interval(ge=0, le=100)] = 0.2
    """Weight of the mean relative depth error in the loss, against the mean colour error."""
    smoothing: Annotated[float, Interval(ge=0, le=0.5)] = 0.004
    """Share by which each step pulls a control value towards the mean of its neighbours in time."""
    mean_rate: Annotated[float, Interval(ge=0, le=1)] = 3e-5
    """Learning rate of the canonical positions, in scene sizes."""
    motion_rate: Annotated[float, Interval(ge=0, le=1)] = 1e-3
    """Learning rate of the position control values and of the nodes, in scene sizes."""
    color_rate: Annotated[float, Interval(ge=0, le=1)] = 1e-3
    """Learning rate of the base colours."""
    color_motion_rate: Annotated[float, Interval(ge=0, le=1)] = 2e-2
    """Learning rate of the colour control values."""
    opacity_rate: Annotated[float, Interval(ge=0, le=1)] = 5e-2
    """Learning rate of the opacity logits."""
    scale_rate: Annotated[float, Interval(ge=0, le=1)] = 1e-2
    """Learning rate of the log-scales."""
    quat_rate: Annotated[float, Interval(ge=0, le=1)] = 1e-3
    """Learning rate of the quaternions."""
    rate_decay: Annotated[float, Interval(ge=1, le=1000)] = 3.0
    """Rates fall by this factor, log-linearly, over the run; those of positions fall farther."""
    sh_degree: Annotated[int, Interval(ge=0, le=3)] | None = None
    """Degree of the spherical harmonics for view-dependent colour; auto: as the clip needs."""
    render_mode: RenderMode = "default"
    """How splats narrower than a pixel are rendered, see RenderMode; a run is rendered as it was trained."""
    keep: Annotated[tuple[Part, ...], EachOnce] = ()
    """Parts to keep although the clip does not need them, to measure what they cost."""
    leave_out: Annotated[
        tuple[Literal["deformation", "color_curves", "tracks", "poses", "lens", "exposure"], ...], EachOnce
    ] = ()
    """Parts to leave out whatever the clip needs."""
    hold_out: bool = False
    """Hold every seventh training frame out, or the middle one of fewer than five, and evaluate on it, for
    choosing settings."""
    checkpoint_every: Annotated[int, Interval(ge=1, le=1_000_000)] = 500
    """Steps between checkpoints."""

    def __post_init__(self) -> None:
        for part in self.leave_out:
            if part in self.keep:
                raise ValueError(f"expected {part} either kept or left out, got both")
