"""Straightened images are what lenses without distortion would show: against textures drawn through both."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from renderer.readers.lenses.calibration import Calibration, LensCalibration, SecondEye
from renderer.readers.lenses.straightening import WIDEST, straight_eyes, straightening

SIZE = 320, 256
BARREL = LensCalibration(
    fx=180, fy=181, cx=162, cy=125, distortion=(-0.33, 0.11, 0.001, -0.002, -0.015), size=SIZE
)
LENSES = {
    "none": LensCalibration(fx=300, fy=300, cx=159.5, cy=127.5),
    "barrel": BARREL,
    "rational": LensCalibration(
        fx=200, fy=200, cx=158, cy=129, distortion=(0.2, 0.1, 0, 0, 0.01, 0.5, 0.2, 0.02)
    ),
    "pincushion": LensCalibration(fx=250, fy=250, cx=160, cy=128, distortion=(0.2, 0.0, 0.0, 0.0)),
    "fisheye": LensCalibration(
        fx=130, fy=130, cx=161, cy=126, model="fisheye", distortion=(0.05, -0.01, 0.003, -0.001)
    ),
}
TURN = cv2.Rodrigues(np.array([0.01, -0.03, 0.02]))[0]
SHIFT = np.array([-4.2, 0.1, -0.05])
RIGHT = LensCalibration(fx=183, fy=184, cx=158, cy=131, distortion=(-0.31, 0.1, 0, 0, -0.01), size=SIZE)
EYES = Calibration(
    lens=BARREL, right=SecondEye(lens=RIGHT, turn=tuple(TURN.ravel().tolist()), shift=tuple(SHIFT))
)


def texture(x, y):
    """(..., 3) uint8 of places on a plane, waves that pixels can hold."""
    waves = [np.sin(9 * x + 5 * y), np.cos(11 * y - 4 * x), np.sin(7 * x * y + 3)]
    return np.stack([np.round(127 + 100 * wave) for wave in waves], axis=-1).astype(np.uint8)


def directions(lens, size=SIZE):
    """(H, W, 2) x and y where z is 1, of what each pixel of the raw image shows."""
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    pixels = np.stack([columns, rows], axis=-1).reshape(-1, 1, 2).astype(np.float64)
    if lens.model == "fisheye":
        found = cv2.fisheye.undistortPoints(pixels, lens.matrix, lens.coefficients)
    else:
        found = undistorted((pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy), lens)
    return found.reshape(size[1], size[0], 2)


def undistorted(places, lens):
    """The inverse of Brown's model with a rational radius, by fixed-point iteration."""
    k1, k2, p1, p2, k3, k4, k5, k6 = (*lens.distortion, *[0] * 8)[:8]
    found = places.copy()
    for _ in range(100):
        x, y = np.moveaxis(found, -1, 0)
        r2 = x**2 + y**2
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        aside = np.stack([2 * p1 * x * y + p2 * (r2 + 2 * x**2), p1 * (r2 + 2 * y**2) + 2 * p2 * x * y], -1)
        found = (places - aside) / radial[..., None]
    return found


def flat(camera):
    """The same of a camera without distortion."""
    columns, rows = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    return np.stack([(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy], axis=-1)


@pytest.mark.parametrize("name", LENSES)
def test_a_straightened_image_is_what_a_flat_lens_would_show(name):
    lens = LENSES[name]
    by = straightening(lens, SIZE)
    found = by.image(texture(*np.moveaxis(directions(lens), -1, 0)))
    wanted = texture(*np.moveaxis(flat(by.camera), -1, 0))
    off = np.abs(found.astype(int) - wanted)[2:-2, 2:-2]
    assert off.max() <= 6
    assert off.mean() < 1
    assert by.mask(np.ones(SIZE[::-1], bool)).all()  # No corner is empty.


def test_as_much_as_can_be_is_shown():
    """Each side of the flat image is as far out as the lens saw there, on one side at least."""
    by = straightening(BARREL, SIZE)
    edge = directions(BARREL)
    across, down = by.camera.cx / by.camera.fx, by.camera.cy / by.camera.fy
    seen = np.abs(edge[125, 0, 0]), np.abs(edge[0, 162, 1])
    assert min(seen[0] - across, seen[1] - down) == pytest.approx(0, abs=0.02)


def test_without_distortion_nothing_changes():
    by = straightening(LENSES["none"], SIZE)
    image = np.random.default_rng(0).integers(0, 256, (*SIZE[::-1], 3), dtype=np.uint8)
    assert by.camera.fx == pytest.approx(300, rel=0.011)
    np.testing.assert_allclose(by.camera.intrinsics[:2, 2], (160, 128))
    smooth = cv2.GaussianBlur(image, (0, 0), 4)
    assert np.median(np.abs(cv2.GaussianBlur(by.image(image), (0, 0), 4).astype(int) - smooth)) <= 3


def test_masks_go_with_the_image():
    by = straightening(BARREL, SIZE)
    raw, wanted = (texture(*np.moveaxis(rays, -1, 0))[..., 0].astype(int) - 127
                   for rays in (directions(BARREL), flat(by.camera)))  # fmt: skip
    clear = np.abs(wanted) > 9  # A pixel beside may lie on the other side of 127.
    np.testing.assert_array_equal(by.mask(raw > 0)[clear], wanted[clear] > 0)


def test_half_the_size_is_the_same_view():
    whole, half = straightening(BARREL, SIZE), straightening(BARREL, (160, 128))
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(half.camera, name) == pytest.approx(getattr(whole.camera, name) / 2, rel=0.02)


def test_a_view_of_half_a_sphere_is_cut_off_where_a_flat_image_ends():
    wide = LensCalibration(fx=100, fy=100, cx=160, cy=128, model="fisheye", distortion=(0, 0, 0, 0))
    camera = straightening(wide, SIZE).camera
    corner = np.hypot(160 / camera.fx, 128 / camera.fy)
    assert corner == pytest.approx(np.tan(WIDEST), rel=0.02)


def test_both_eyes_show_the_same_rows_and_distances_follow_from_columns():
    """A plane that leans, textured, drawn through both raw lenses; rectified, it is where its depth says."""
    eyes = straight_eyes(EYES, SIZE)
    plane = np.array([0.1, -0.05, 1.0]), 60.0  # Points with normal . x = 60 mm, in the left eye's axes.

    def hit(rays, turn, shift):
        """The points of the plane that rays from an eye reach: x_eye = turn x + shift."""
        toward, origin = rays @ turn, -turn.T @ shift
        return origin + toward * ((plane[1] - origin @ plane[0]) / (toward @ plane[0]))[..., None]

    def drawn(rays, turn, shift):
        full = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=-1)
        points = hit(full, turn, shift)
        return texture(points[..., 0] / 20, points[..., 1] / 20)

    left = eyes.left.image(drawn(directions(BARREL), np.eye(3), np.zeros(3)))
    right = eyes.right.image(drawn(directions(RIGHT), TURN, SHIFT))
    camera = eyes.left.camera
    first, second, *_ = cv2.stereoRectify(
        BARREL.matrix, BARREL.coefficients, RIGHT.matrix, RIGHT.coefficients, SIZE, TURN, SHIFT[:, None],
        flags=cv2.CALIB_ZERO_DISPARITY, alpha=0,
    )[:2]  # fmt: skip
    rays = np.concatenate([flat(camera), np.ones((SIZE[1], SIZE[0], 1))], axis=-1)
    points = hit(rays, first, np.zeros(3))
    depth = (points @ first.T)[..., 2]
    assert np.abs(left.astype(int) - drawn(flat(camera), first, np.zeros(3)))[3:-3, 3:-3].mean() < 1
    disparity = camera.fx * eyes.baseline / depth
    columns, rows = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    across = (columns - disparity).astype(np.float32)
    moved = cv2.remap(right, across, rows.astype(np.float32), cv2.INTER_CUBIC)
    inside = across > 4
    assert np.abs(moved.astype(int) - left)[inside].mean() < 1.5
    assert eyes.baseline == pytest.approx(np.linalg.norm(SHIFT))
    assert second.shape == (3, 3)


@pytest.mark.parametrize(
    ("lens", "size", "said"),
    [
        (BARREL, (320, 240), "got one of 320x256, the images are 320x240"),
        (LensCalibration(fx=900, fy=900, cx=960, cy=540), SIZE, "middle of the view within 320x256"),
        (LensCalibration(fx=40, fy=40, cx=160, cy=128, distortion=(-5, 0, 0, 0)), SIZE, "folds"),
    ],
)
def test_what_does_not_fit_is_refused(lens, size, said):
    with pytest.raises(ValueError, match=said):
        straightening(lens, size)


def test_pairs_that_cannot_be_rectified_are_refused():
    with pytest.raises(ValueError, match="both eyes"):
        straight_eyes(Calibration(lens=BARREL), SIZE)
    above = SecondEye(lens=RIGHT, turn=tuple(np.eye(3).ravel()), shift=(0.1, -4.0, 0.0))
    with pytest.raises(ValueError, match="one above the other"):
        straight_eyes(Calibration(lens=BARREL, right=above), SIZE)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
@pytest.mark.parametrize("shape", [(256, 320), (256, 320, 3)])
def test_floats_are_straightened_as_bytes_are_and_stay_in_their_range(dtype, shape):
    levels = np.where(np.random.default_rng(0).random(shape) > 0.5, 255, 0).astype(np.uint8)
    by = straightening(BARREL, SIZE)
    moved = by.image((levels / 255).astype(dtype))
    assert moved.dtype == dtype
    assert (moved.min(), moved.max()) == (0, 1)
    assert np.abs(255 * moved.astype(float) - by.image(levels)).max() < 1
