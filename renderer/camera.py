"""Pinhole camera in OpenCV axes: x right, y down, z forward; pixel centres at +0.5."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from operator import index, mul
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.budget import budget

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
NARROWEST, WIDEST = 1e-7, 1e4
"""Width by focal length; 2 is 90 degrees."""
FARTHEST: Final = 1e15
"""Of positions, and pixels of the principal point: their squares are numbers in float32."""
SKEWEST: Final = 0.1
"""Largest element of R R^T - 1 that rounding and drift explain; beyond, R is no rotation."""


def _identity() -> FloatArray:
    return np.eye(4)


class CameraError(ValueError):
    """Invalid camera parameters: the text says what was expected.

    Example:
        >>> from renderer import Camera, CameraError
        >>> try:
        ...     Camera(fx=100, fy=100, cx=32, cy=24, width=0, height=48)
        ... except CameraError as error:
        ...     print(error)
        expected a camera size of at least 1x1 pixels, got 0x48
    """


@dataclass(frozen=True, eq=False)
class Camera:
    """Intrinsics in pixels and the (4, 4) float64 world-to-camera matrix ("viewmat" in the field).

    A point at camera coordinates (x, y, z) falls on pixel position (fx x / z + cx, fy y / z + cy);
    pixel (column, row) covers [column, column + 1) x [row, row + 1).

    Raises:
        CameraError: sizes or focal lengths that are not positive, or a matrix that is not a finite (4, 4) or
            does more than rotate and translate, as a mirror does; or numbers beyond what can be rendered.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera
        >>> camera = Camera(fx=100, fy=100, cx=32, cy=24, width=64, height=48)
        >>> pixels, depths = camera.project(np.array([[0.1, 0.0, 1.0]]))
        >>> pixels.tolist(), depths.tolist()
        ([[42.0, 24.0]], [1.0])
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    camera_from_world: FloatArray = field(default_factory=_identity)

    def __post_init__(self) -> None:
        for name in ("fx", "fy", "cx", "cy"):
            object.__setattr__(self, name, _number(getattr(self, name), name))
        for name in ("width", "height"):
            object.__setattr__(self, name, whole_pixels(getattr(self, name), name))
        if self.width < 1 or self.height < 1:
            raise CameraError(
                f"expected a camera size of at least 1x1 pixels, got {self.width}x{self.height}"
            )
        if not all(map(math.isfinite, self.lens)) or self.fx <= 0 or self.fy <= 0:
            raise CameraError(f"expected finite intrinsics with fx, fy > 0, got fx fy cx cy = {self.lens}")
        if not all(NARROWEST <= self.width / focal <= WIDEST for focal in (self.fx, self.fy)):
            widths = f"{1 / WIDEST:g} to {1 / NARROWEST:g} widths"
            raise CameraError(f"expected focal lengths of {widths}, got {self.fx} and {self.fy}")
        if max(abs(self.cx), abs(self.cy)) > FARTHEST:
            raise CameraError(
                f"expected a principal point nearer than {FARTHEST:g}, got {self.cx} and {self.cy}"
            )
        budget().require(pixels=self.width * self.height)
        matrix = _matrix(self.camera_from_world)
        _require_pose(matrix)
        matrix.setflags(write=False)
        object.__setattr__(self, "camera_from_world", matrix)

    @classmethod
    def from_fov(cls, fov_x: float, width: int, height: int) -> Camera:
        """Centred camera at the origin with a horizontal field of view of `fov_x` degrees, in (0, 180)."""
        if not 0 < fov_x < 180:
            raise CameraError(f"expected a field of view in (0, 180) degrees, got {fov_x}")
        focal = 0.5 * width / math.tan(math.radians(fov_x) / 2)
        return cls(focal, focal, width / 2, height / 2, width, height)

    @classmethod
    def nearest(
        cls, fx: float, fy: float, cx: float, cy: float, width: int, height: int, pose: FloatArray
    ) -> Camera:
        """From what was worked out of other cameras: lens and position are kept within what one may have."""
        least, most = width / WIDEST * (1 + 1e-9), width / NARROWEST * (1 - 1e-9)
        fx, fy = (min(max(focal, least), most) for focal in (fx, fy))
        cx, cy = (min(max(middle, -FARTHEST), FARTHEST) for middle in (cx, cy))
        if max(map(abs, pose[:3, 3].tolist())) > FARTHEST:
            pose = pose.copy()
            pose[:3, 3] = np.clip(pose[:3, 3], -FARTHEST, FARTHEST)
        return cls(fx, fy, cx, cy, width, height, pose)

    @property
    def lens(self) -> tuple[float, float, float, float]:
        """Focal lengths and principal point: fx, fy, cx, cy, in pixels."""
        return self.fx, self.fy, self.cx, self.cy

    @property
    def intrinsics(self) -> FloatArray:
        """The (3, 3) matrix from camera coordinates to homogeneous pixels."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def world_from_camera(self) -> FloatArray:
        return np.linalg.inv(self.camera_from_world).astype(np.float64)

    @property
    def position(self) -> FloatArray:
        """(3,) camera centre in world coordinates."""
        return self.world_from_camera[:3, 3]

    @property
    def sides(self) -> FloatArray:
        """(4, 4) planes through the centre and the four sides of the image, in world coordinates: a point is
        in view where `sides @ (x, y, z, 1)`, its distances to them, are all at least 0."""
        inwards = np.array(
            [
                [self.fx, 0.0, self.cx],
                [-self.fx, 0.0, self.width - self.cx],
                [0.0, self.fy, self.cy],
                [0.0, -self.fy, self.height - self.cy],
            ]
        )
        inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
        return inwards @ self.camera_from_world[:3]

    def has_pose_of(self, other: Camera) -> bool:
        return np.array_equal(self.camera_from_world, other.camera_from_world)

    def sees_only(self, other: Camera) -> bool:
        """Whether it has the other's pose, and nothing in view that the other has not."""
        if not self.has_pose_of(other):
            return False
        (left, top, right, bottom), outer = self._slopes, other._slopes
        return left >= outer[0] and top >= outer[1] and right <= outer[2] and bottom <= outer[3]

    @property
    def _slopes(self) -> tuple[float, float, float, float]:
        """x/z, y/z of the first corner of the image, and of the last; to 1 in 10^9, which resizing loses."""
        ends = (-self.cx / self.fx, -self.cy / self.fy)
        far = ((self.width - self.cx) / self.fx, (self.height - self.cy) / self.fy)
        left, top, right, bottom = (round(slope, 9) for slope in (*ends, *far))
        return left, top, right, bottom

    @property
    def field_of_view(self) -> float:
        """Horizontal, in degrees."""
        return math.degrees(math.atan(self.cx / self.fx) + math.atan((self.width - self.cx) / self.fx))

    def resized(self, width: int, height: int) -> Camera:
        """The same view sampled with another number of pixels."""
        across, down = width / self.width, height / self.height
        return Camera.nearest(
            self.fx * across, self.fy * down, self.cx * across, self.cy * down,
            width, height, self.camera_from_world,
        )  # fmt: skip

    def fitted(self, width: int, height: int) -> Camera:
        """The whole field of view in the middle of an image of another shape, pixels scaled evenly."""
        scale = min(width / self.width, height / self.height)
        return Camera.nearest(
            self.fx * scale, self.fy * scale,
            self.cx * scale + (width - self.width * scale) / 2,
            self.cy * scale + (height - self.height * scale) / 2,
            width, height, self.camera_from_world,
        )  # fmt: skip

    def shaped(self, width: int, height: int) -> Camera:
        """`resized` where the shape stays, else `fitted`: nothing is stretched."""
        return (self.resized if self.has_shape(width, height) else self.fitted)(width, height)

    def has_shape(self, width: int, height: int) -> bool:
        """Whether so many pixels have the same aspect ratio."""
        return width * self.height == height * self.width

    def moved(self, camera_from_world: FloatArray) -> Camera:
        """The same lens at another pose. Raises ValueError: it is none, see Camera."""
        return replace(self, camera_from_world=camera_from_world)

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """World points (N, 3) to pixel positions (N, 2) and depths along +z (N,)."""
        local = points @ self.camera_from_world[:3, :3].T + self.camera_from_world[:3, 3]
        depth = local[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            x = self.fx * local[:, 0] / depth + self.cx
            y = self.fy * local[:, 1] / depth + self.cy
        return np.stack([x, y], axis=1), depth

    def unproject(self, depth: NDArray[np.floating[Any]]) -> FloatArray:
        """Depth map (H, W) along +z to the world points (H, W, 3) behind the pixel centres."""
        if depth.shape != (self.height, self.width):
            raise ValueError(f"expected depth of {self.height}x{self.width}, got {depth.shape}")
        z = depth.astype(np.float64)
        x = (np.arange(self.width) + 0.5 - self.cx) / self.fx * z
        y = (np.arange(self.height)[:, None] + 0.5 - self.cy) / self.fy * z
        pose = self.world_from_camera
        return np.stack([x, y, z], axis=-1) @ pose[:3, :3].T + pose[:3, 3]

    def to_json(self) -> dict[str, Any]:
        return {
            "fx": self.fx, "fy": self.fy, "cx": self.cx, "cy": self.cy,
            "width": self.width, "height": self.height,
            "camera_from_world": self.camera_from_world.tolist(),
        }  # fmt: skip

    @classmethod
    def from_json(cls, values: dict[str, Any]) -> Camera:
        """Inverse of `to_json`. Raises ValueError when a field is missing, infinite or of the wrong kind."""
        try:
            numbers = {name: float(values[name]) for name in ("fx", "fy", "cx", "cy")}
            matrix = np.array(values["camera_from_world"], dtype=np.float64)
            width, height = (whole_pixels(values[name], name) for name in ("width", "height"))
            return cls(**numbers, width=width, height=height, camera_from_world=matrix)
        except (KeyError, TypeError, OverflowError) as error:
            got = f"no {error.args[0]}" if isinstance(error, KeyError) else error
            raise CameraError(f"expected fx fy cx cy width height camera_from_world, got {got}") from error

    def _key(self) -> tuple[Any, ...]:
        pose = self.camera_from_world + 0.0  # -0 and 0 are one pose.
        return (*self.lens, self.width, self.height, pose.tobytes())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Camera) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


def whole_pixels(value: object, name: str) -> int:
    """As Python has it, so that JSON can hold it. Raises CameraError: it is not whole."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise CameraError(f"expected a whole number of pixels as {name}, got {repr(value)[:40]}")
    return index(value)


def _number(value: Any, name: str) -> float:
    """As Python has it, so that JSON can hold it."""
    if isinstance(value, float | int):
        return value
    try:
        return float(value.__float__())
    except (AttributeError, TypeError) as error:  # A text has none.
        raise CameraError(f"expected a number as {name}, got {repr(value)[:40]}") from error


def _matrix(given: object) -> FloatArray:
    """A copy."""
    try:
        matrix = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        got = repr(given)[:40]
        raise CameraError(f"expected camera_from_world to be a (4, 4) matrix, got {got}") from error
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise CameraError(
            f"expected camera_from_world to be a finite (4, 4) matrix, got shape {matrix.shape}"
        )
    return matrix


def _require_pose(matrix: FloatArray) -> None:
    """In plain numbers: a tenth of the time that arrays so small take."""
    *rows, last = matrix.tolist()
    turn, place = [row[:3] for row in rows], [row[3] for row in rows]
    skew = _skew(turn)
    if skew > SKEWEST:
        raise CameraError(f"expected a rotation in camera_from_world, got R R^T - 1 of up to {skew:.2g}")
    if _is_mirror(turn):
        raise CameraError("expected a rotation in camera_from_world, got one that mirrors")
    if max(map(abs, place)) > FARTHEST or math.dist(last, (0, 0, 0, 1)) > SKEWEST:
        raise CameraError(
            f"expected a translation of at most {FARTHEST:g} and a last row 0 0 0 1 in "
            f"camera_from_world, got {place} and {last}"
        )


def _is_mirror(turn: list[list[float]]) -> bool:
    """Whether the determinant is negative."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0


def _skew(turn: list[list[float]]) -> float:
    """The largest element of R R^T - 1; infinite where R has larger elements than any rotation."""
    if max(abs(value) for row in turn for value in row) > 2:
        return math.inf
    pairs = ((i, j) for i in range(3) for j in range(i, 3))
    return float(max(abs(sum(map(mul, turn[i], turn[j])) - (i == j)) for i, j in pairs))
