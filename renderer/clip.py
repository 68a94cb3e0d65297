"""A clip as the rest of the program sees it: frames with image, depth, masks, time and camera."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray

ByteImage = NDArray[np.uint8]
BoolImage = NDArray[np.bool_]

Split = Literal["field", "even-odd"]
"""Frames held out of training: every eighth from the second on, or the odd ones."""

DepthOrigin = Literal["measured", "beside", "stereo", "monocular", "brightness", "motion"]
"""Files of the clip's layout, files beside pictures, pairs that are matched, maps of a network, a guess, the
camera's motion."""

CLOCK = 0.005
"""Seconds, well above the rounding of times in containers, a millisecond at each end."""


class ClipError(ValueError):
    """A clip cannot be read: the text says what was expected, what came, and where.

    Example:
        >>> from pathlib import Path
        >>> from renderer import ClipError, open_clip
        >>> try:
        ...     open_clip(Path("nothing-here"))
        ... except ClipError as error:
        ...     print(error)
        expected a clip, got no such file or folder: nothing-here
    """


def held_out_frames(count: int, split: Split, passed_over: Collection[int]) -> tuple[int, ...]:
    """Frames of a clip of `count` that are held out: (i - 1) % 8 == 0, the split of the field, or the odd;
    without those that are passed over."""
    every = range(1, count, 8 if split == "field" else 2)
    return tuple(index for index in every if index not in passed_over)


@dataclass(frozen=True, eq=False)
class Frame:
    """One moment of a clip: image, depth, masks, time and camera.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera, Frame
        >>> image, keep = np.full((24, 32, 3), 120, np.uint8), np.ones((24, 32), bool)
        >>> depth = np.full((24, 32), 50, np.float32)
        >>> depth[:12] = 0
        >>> frame = Frame(0, 0.0, image, Camera.from_fov(60, 32, 24), keep, keep, depth)
        >>> float(frame.depth_mask.mean())
        0.5
    """

    index: int
    """Position in the clip, from 0."""
    time: float
    """In [0, 1): index / number of frames."""
    image: ByteImage
    """(H, W, 3) RGB."""
    camera: Camera
    tissue_mask: BoolImage
    """(H, W), True = tissue whose colour is supervised; False = tool, burned-in text, surround."""
    evaluation_mask: BoolImage
    """(H, W), True = pixel counted by the metrics."""
    depth: NDArray[np.float32] | None = None
    """(H, W) along +z in the clip's unit; 0, NaN and infinity = no measurement. None when the clip has no
    depth."""
    depth_is_guess: bool = False
    """Known up to scale and shift of its inverse at best: no depth is measured against it."""
    tools_are_known: bool = False
    """A mask of its own says where tools are: nobody looks for them."""
    gain: float = 1.0
    """Brightness of the image against the clip's common exposure, in which a model is: one number, found from
    the image itself and those beside it, never from the model, as exposure is compensated for elsewhere."""

    def __post_init__(self) -> None:
        """Raises ClipError: arrays of other types than above, such as images in [0, 1], or of another size
        than the camera's."""
        size = self.camera.height, self.camera.width
        _require(self.image, "image", np.uint8, (*size, 3), self.index)
        _require(self.tissue_mask, "tissue_mask", np.bool_, size, self.index)
        _require(self.evaluation_mask, "evaluation_mask", np.bool_, size, self.index)
        if self.depth is not None:
            _require(self.depth, "depth", np.floating, size, self.index)
            if not self.depth.dtype.isnative:  # As of PFM files; OpenCV reads the order of this machine.
                native = self.depth.astype(self.depth.dtype.newbyteorder("="))
                object.__setattr__(self, "depth", native)

    @property
    def measured_depth(self) -> NDArray[np.float32] | None:
        """What depth errors are measured against."""
        return None if self.depth_is_guess else self.depth

    @property
    def depth_mask(self) -> BoolImage:
        """(H, W), True where depth is measured on tissue."""
        if self.depth is None:
            return np.zeros(self.tissue_mask.shape, dtype=bool)
        return self.tissue_mask & (self.depth > 0) & (self.depth < np.inf)

    @property
    def median_depth(self) -> float | None:
        """Of the tissue with measured depth; None without any."""
        known = self.depth_mask
        return float(np.median(self.depth[known])) if self.depth is not None and known.any() else None


def _require(
    array: NDArray[np.generic], name: str, kind: type[np.generic], shape: tuple[int, ...], index: int
) -> None:
    if not np.issubdtype(array.dtype, kind) or array.shape != shape:
        wanted = f"{'float' if kind is np.floating else kind.__name__.rstrip('_')} of shape {shape}"
        got = f"{array.dtype} of shape {array.shape}"
        raise ClipError(f"expected Frame.{name} as {wanted}, got {got}: frame {index}")


def within(frame: Frame, kept: BoolImage) -> Frame:
    """The same frame where only these pixels (H, W) are tissue, and evaluated."""
    tissue, evaluated = frame.tissue_mask & kept, frame.evaluation_mask & kept
    return replace(frame, tissue_mask=tissue, evaluation_mask=evaluated)


@dataclass(frozen=True, eq=False)
class SparsePoints:
    """What structure from motion leaves of the shape: too few points to supervise, enough to start from."""

    positions: FloatArray
    """(P, 3) in world coordinates."""
    colors: ByteImage | None = None
    """(P, 3) RGB, where the file has them."""


def numbered(index: int, count: int) -> int:
    """The number of one of `count` frames, counted from their end where it is below 0, as in a list.

    Raises IndexError: there is none.
    """
    try:
        return range(count)[index]
    except IndexError:
        raise IndexError(f"expected a frame from 0 to {count - 1}, got {index}") from None


@dataclass(frozen=True, eq=False)
class Clip:
    """A readable clip; frames are decoded on request, never all at once.

    `open_clip` opens one from files; one from arrays is made as below. Reading a damaged frame raises
    ClipError, one that is not there IndexError. Another process opens it anew: it cannot be pickled.

    Example:
        >>> from pathlib import Path
        >>> import numpy as np
        >>> from renderer import Camera, Clip, Frame
        >>> camera = Camera.from_fov(60, 32, 24)
        >>> image, keep = np.full((24, 32, 3), 120, np.uint8), np.ones((24, 32), bool)
        >>> depth = np.full((24, 32), 50, np.float32)
        >>> clip = Clip(
        ...     name="flat",
        ...     path=Path("flat"),
        ...     format="images",
        ...     cameras=(camera,) * 10,
        ...     read_frame=lambda index: Frame(index, index / 10, image, camera, keep, keep, depth),
        ...     read_image=lambda index: image,
        ...     labels=tuple(f"{index:03d}" for index in range(10)),
        ...     has_depth=True,
        ...     unit="mm",
        ... )
        >>> len(clip), clip.size, clip.test_indices  # every eighth from the second on is held out
        (10, (32, 24), (1, 9))
        >>> clip.every(2).read_frame(3).time
        0.6
    """

    name: str
    path: Path
    format: str
    """The name of its Layout in `layouts.py`; another where it is of no file, such as "live"."""
    cameras: tuple[Camera, ...]
    """One a frame."""
    read_frame: Callable[[int], Frame]
    read_image: Callable[[int], ByteImage]
    """Only the image of a frame: cheaper than read_frame."""
    labels: tuple[str, ...]
    """What a person calls each frame: its file name or number."""
    has_depth: bool
    unit: str
    """"mm", or "scene units" where the scale is unknown."""
    depth_origin: DepthOrigin = "measured"
    """Where there is depth; "motion": where there are, or are to be found, points without."""
    why_no_depth: str = ""
    """Where there is none although something promises it: why, and what to do."""
    frames_per_second: float | None = None
    frame_times: tuple[float, ...] | None = None
    """Seconds from the first frame at which each is shown, of a video."""
    pixel_aspect: float = 1.0
    """Width of a pixel by its height, as a video says."""
    notices: tuple[str, ...] = ()
    """One sentence for each oddity met while opening: stray files, inverted masks, burned-in rows."""
    split: Split = "field"
    """Which frames are held out."""
    passed_over: frozenset[int] = frozenset()
    """Frames that are neither trained on nor held out: where their camera was is not known."""
    points: SparsePoints | None = None
    """Where structure from motion found the tissue, for clips that come with it."""
    baseline: float | None = None
    """Between the eyes in the clip's unit, where the images are the left ones of calibrated pairs."""
    calibrated: bool = False
    """Its lens is known from a calibration that was given, and its images are undistorted by that."""
    bits: int = 16
    """That values of its 16-bit image files use; the right eye's are read alike."""
    read_right: Callable[[int], ByteImage] | None = None
    """The right eye's picture of a frame, where the clip's own file holds it beside the left one."""
    read_visible: Callable[[int], BoolImage | None] | None = None
    """(H, W) of a frame, False where its image is fully transparent; None: it is nowhere."""

    def __len__(self) -> int:
        return len(self.cameras)

    def lies_at(self, path: Path) -> bool:
        """Whether that is its path, in whatever words; links are not followed, and no file is looked at."""
        return os.path.abspath(self.path) == os.path.abspath(path)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels, of the first frame."""
        return self.cameras[0].width, self.cameras[0].height

    @cached_property
    def has_one_size(self) -> bool:
        """All frames are of that size; else they are single images, each with a camera of its own. Looked at
        once: panels ask in every frame of the window."""
        return all((camera.width, camera.height) == self.size for camera in self.cameras)

    @cached_property
    def times(self) -> tuple[float, ...]:
        return tuple(index / len(self) for index in range(len(self)))

    @cached_property
    def is_steady(self) -> bool:
        """Whether its frames come evenly, as far as their own times tell; looked at once, as its size."""
        times, speed = self.frame_times, self.frames_per_second
        if not times or not speed:
            return True
        return all(abs(time - index / speed) <= CLOCK for index, time in enumerate(times))

    @cached_property
    def test_indices(self) -> tuple[int, ...]:
        """Frames held out for evaluation."""
        return held_out_frames(len(self), self.split, self.passed_over)

    @cached_property
    def train_indices(self) -> tuple[int, ...]:
        return tuple(sorted(set(range(len(self))) - set(self.test_indices) - self.passed_over))

    @cached_property
    def camera_is_fixed(self) -> bool:
        return all(camera == self.cameras[0] for camera in self.cameras)

    def every(self, step: int) -> Clip:
        """The frames 0, step, 2 step, ... as a clip of their own, numbered and timed anew.

        Raises:
            ValueError: a step below 1.
        """
        if step < 1:
            raise ValueError(f"expected a step of 1 or more, got {step}")
        return self._of(range(0, len(self), step))

    def between(self, first: int, last: int) -> Clip:
        """The frames from `first` to `last`, both included, numbered and timed anew."""
        return self._of(range(first, last + 1))

    def _of(self, kept: range) -> Clip:
        def place(index: int) -> int:
            return kept[numbered(index, len(kept))]

        def read_frame(index: int) -> Frame:
            index = numbered(index, len(kept))
            return replace(self.read_frame(kept[index]), index=index, time=index / len(kept))

        times, read_right, read_visible = self.frame_times, self.read_right, self.read_visible
        taken = slice(kept.start, kept.stop, kept.step)
        return replace(
            self,
            cameras=self.cameras[taken],
            read_frame=read_frame,
            read_image=lambda index: self.read_image(place(index)),
            labels=self.labels[taken],
            frames_per_second=self._rate_of(kept),
            passed_over=frozenset(kept.index(index) for index in self.passed_over if index in kept),
            frame_times=times and tuple(time - times[kept.start] for time in times[taken]),
            read_right=read_right and (lambda index: read_right(place(index))),
            read_visible=read_visible and (lambda index: read_visible(place(index))),
        )

    def _rate_of(self, kept: range) -> float | None:
        """The clip's, but where the frames kept are further apart or closer by their own times."""
        speed = self.frames_per_second and self.frames_per_second / kept.step
        times = (self.frame_times or ())[kept.start : kept.stop : kept.step]
        if not speed or len(times) < 2:
            return speed
        gaps, seconds = len(times) - 1, times[-1] - times[0]
        is_even = abs(seconds - gaps / speed) <= CLOCK
        return speed if is_even or seconds <= 0 else gaps / seconds

    def through(self, cameras: tuple[Camera, ...]) -> Clip:
        """The same clip seen by these cameras, one a frame. Raises ValueError: another number of them."""
        if len(cameras) != len(self):
            raise ValueError(f"expected {len(self)} cameras, one a frame, got {len(cameras)}")

        def read_frame(index: int) -> Frame:
            return replace(self.read_frame(index), camera=cameras[index])

        return replace(self, cameras=cameras, read_frame=read_frame)

    def within(self, kept: BoolImage) -> Clip:
        """The same clip where only these pixels (H, W) of every frame are tissue, and evaluated."""

        return replace(self, read_frame=lambda index: within(self.read_frame(index), kept))

    def with_images(self, change: Callable[[ByteImage, Frame], ByteImage], name: str) -> Clip:
        """The same clip with every image passed through `change`, for example enhanced."""

        def read_frame(index: int) -> Frame:
            frame = self.read_frame(index)
            return replace(frame, image=change(frame.image, frame))

        return replace(
            self, name=name, read_frame=read_frame, read_image=lambda index: read_frame(index).image
        )
