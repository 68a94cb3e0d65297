"""LPIPS with random weights against the definition in float64; what is refused as weights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.lib.stride_tricks import sliding_window_view
from safetensors.torch import save_file

from renderer.lpips import LAYERS, Lpips, LpipsWeightsError, read_lpips

Arrays = dict[str, torch.Tensor]


def random_weights() -> tuple[Arrays, Arrays]:
    """Of AlexNet and of the heads, with signals of order 1 in every layer."""
    rng = np.random.default_rng(3)
    network: Arrays = {"classifier.1.weight": torch.zeros(2, 2)}
    heads: Arrays = {}
    for index, layer in enumerate(LAYERS):
        spread = np.sqrt(2 / np.prod(layer.shape[1:]))
        network[f"features.{layer.number}.weight"] = tensor(spread * rng.standard_normal(layer.shape))
        network[f"features.{layer.number}.bias"] = tensor(0.1 * rng.standard_normal(layer.shape[0]))
        heads[f"lin{index}.model.1.weight"] = tensor(rng.random((1, layer.shape[0], 1, 1)))
    return network, heads


def tensor(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values.astype(np.float32))


NETWORK, HEADS = random_weights()


def write(folder: Path, network: Arrays = NETWORK, heads: Arrays = HEADS) -> Path:
    torch.save(network, folder / "alexnet-owt-0.pth")
    torch.save(heads, folder / "alex.pth")
    return folder


@pytest.fixture(scope="module")
def lpips(tmp_path_factory: pytest.TempPathFactory) -> Lpips:
    return read_lpips(write(tmp_path_factory.mktemp("weights")))


def literal_convolution(x, kernel, bias, stride, padding):
    """(C, h, w) to (out, h', w'): every window times every kernel."""
    padded = np.pad(x, ((0, 0), (padding, padding), (padding, padding)))
    size = kernel.shape[2]
    windows = sliding_window_view(padded, (size, size), axis=(1, 2))[:, ::stride, ::stride]
    return np.einsum("chwij,ocij->ohw", windows, kernel, optimize=True) + bias[:, None, None]


def literal_pool(x):
    return sliding_window_view(x, (3, 3), axis=(1, 2))[:, ::2, ::2].max(axis=(3, 4))


def literal_features(picture):
    """AlexNet up to its fifth ReLU as it is drawn: (number in `features`, stride, padding), pools between."""
    weights = {name: array.numpy().astype(np.float64) for name, array in NETWORK.items()}
    signal = (2 * picture - 1 - [-0.030, -0.088, -0.188]) / [0.458, 0.448, 0.450]
    signal, taken = signal.transpose(2, 0, 1), []
    for step in [(0, 4, 2), "pool", (3, 1, 2), "pool", (6, 1, 1), (8, 1, 1), (10, 1, 1)]:
        if step == "pool":
            signal = literal_pool(signal)
            continue
        number, stride, padding = step
        kernel, bias = weights[f"features.{number}.weight"], weights[f"features.{number}.bias"]
        signal = np.maximum(literal_convolution(signal, kernel, bias, stride, padding), 0)
        taken.append(signal / (np.sqrt((signal**2).sum(axis=0)) + 1e-10))
    return taken


def literal_lpips(image, reference, mask):
    pairs = zip(*(literal_features(p * mask[:, :, None]) for p in (image, reference)), strict=True)
    total = 0.0
    for index, (x, y) in enumerate(pairs):
        head = HEADS[f"lin{index}.model.1.weight"].numpy().astype(np.float64).reshape(-1, 1, 1)
        total += (head * (x - y) ** 2).sum(axis=0).mean()
    return total


@pytest.fixture
def pictures() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two pictures (45, 52, 3) and a mask with a hole."""
    rng = np.random.default_rng(5)
    reference = rng.random((45, 52, 3))
    image = np.clip(reference + 0.2 * rng.standard_normal(reference.shape), 0, 1)
    mask = np.ones((45, 52), dtype=bool)
    mask[10:22, 30:47] = False
    return image, reference, mask


def test_it_is_the_definition(lpips, pictures):
    expected = literal_lpips(*pictures)
    assert expected > 0.01
    assert lpips.distance(*pictures) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("shape", [(31, 31), (31, 70), (64, 33)])
def test_it_is_the_definition_at_any_size(lpips, shape):
    image, reference = np.random.default_rng(8).random((2, *shape, 3))
    everything = np.ones(shape, dtype=bool)
    expected = literal_lpips(image, reference, everything)
    assert lpips.distance(image, reference, everything) == pytest.approx(expected, rel=1e-5)


def test_equal_pictures_are_at_no_distance_and_order_does_not_matter(lpips, pictures):
    image, reference, mask = pictures
    assert lpips.distance(image, image, mask) == 0
    there, back = lpips.distance(image, reference, mask), lpips.distance(reference, image, mask)
    assert there == pytest.approx(back, rel=1e-6)


def test_pixels_outside_the_mask_do_not_matter(lpips, pictures):
    image, reference, mask = pictures
    changed = np.where(mask[:, :, None], image, np.nan)
    assert lpips.distance(changed, reference, mask) == lpips.distance(image, reference, mask)


def test_it_grows_with_noise_and_sees_little_of_it(lpips, pictures):
    _, reference, mask = pictures
    noise = np.random.default_rng(1).standard_normal(reference.shape)
    values = [lpips.distance(reference + spread * noise, reference, mask) for spread in (0.001, 0.01, 0.1)]
    assert 0 < values[0] < values[1] < values[2]


def test_nothing_to_look_at_is_nan(lpips):
    picture = np.zeros((40, 40, 3))
    assert np.isnan(lpips.distance(picture, picture, np.zeros((40, 40), dtype=bool)))
    assert np.isnan(lpips.distance(picture[:30], picture[:30], np.ones((30, 40), dtype=bool)))


def test_pictures_that_do_not_fit_are_refused(lpips):
    picture, mask = np.zeros((40, 40, 3)), np.ones((40, 40), dtype=bool)
    with pytest.raises(ValueError, match="one shape"):
        lpips.distance(picture, picture[:39], mask)
    with pytest.raises(ValueError, match="three channels"):
        lpips.distance(picture[..., :1], picture[..., :1], mask)


def test_every_container_gives_the_same_distance(lpips, pictures, tmp_path):
    save_file(NETWORK | HEADS, tmp_path / "both.safetensors")
    old = tmp_path / "old"
    old.mkdir()
    torch.save(NETWORK, old / "alexnet.pth", _use_new_zipfile_serialization=False)
    torch.save(HEADS, old / "alex.pth", _use_new_zipfile_serialization=False)
    for folder in (tmp_path, old):
        assert read_lpips(folder).distance(*pictures) == lpips.distance(*pictures)


class Harmful:
    """What a pickle could run when it is read."""

    def __init__(self, marker: Path) -> None:
        self.marker = marker

    def __reduce__(self):
        return Path.touch, (self.marker,)


def damaged(folder: Path) -> dict[str, Path]:
    """Folders of weights, each with one thing wrong."""
    layer = "features.3.weight"
    wrong: dict[str, tuple[Arrays, Arrays]] = {
        "shape": (NETWORK | {layer: torch.zeros(192, 64, 3, 3)}, HEADS),
        "missing": ({name: array for name, array in NETWORK.items() if name != layer}, HEADS),
        "not an array": (NETWORK | {layer: "words"}, HEADS),
        "nan": (NETWORK | {layer: torch.full_like(NETWORK[layer], torch.nan)}, HEADS),
        "negative": (NETWORK, HEADS | {"lin2.model.1.weight": -HEADS["lin2.model.1.weight"]}),
        "a list": ([1, 2], HEADS),
    }
    paths = {name: folder / name for name in (*wrong, "empty", "half", "two", "text", "harmful", "cut")}
    for name, path in paths.items():
        path.mkdir()
        write(path, *wrong.get(name, (NETWORK, HEADS)))
    for name in ("empty", "half"):
        (paths[name] / "alex.pth").unlink()
    (paths["empty"] / "alexnet-owt-0.pth").unlink()
    torch.save(NETWORK, paths["two"] / "alexnet-1.pth")
    (paths["text"] / "alex.pth").write_text("no weights at all")
    torch.save({"x": Harmful(folder / "ran")}, paths["harmful"] / "alex.pth")
    save_file({"x": torch.zeros(3)}, paths["cut"] / "a.safetensors")
    cut = paths["cut"] / "a.safetensors"
    cut.write_bytes(cut.read_bytes()[:-4])
    return paths


WORDS = {
    "shape": r"features.3.weight of shape \(192, 64, 5, 5\), got \(192, 64, 3, 3\)",
    "missing": r"features.3.weight of shape .*, got none",
    "not an array": r"features.3.weight of shape .*, got none",
    "nan": "finite numbers in features.3.weight",
    "negative": "linear weights of 0 or more",
    "a list": "expected named arrays, got list",
    "empty": r"alexnet\*.pth and alex.pth.*got none",
    "half": "got alexnet-owt-0.pth",
    "two": "got alex.pth, alexnet-1.pth, alexnet-owt-0.pth",
    "text": "expected a file of weights",
    "harmful": "expected a file of weights",
    "cut": "expected a file of weights",
}


def test_weights_that_cannot_be_used_are_refused_in_one_line_and_never_run(tmp_path):
    folders = damaged(tmp_path)
    assert set(folders) == set(WORDS)
    for name, folder in folders.items():
        with pytest.raises(LpipsWeightsError, match=WORDS[name]) as refused:
            read_lpips(folder)
        assert "\n" not in str(refused.value)
        assert str(folder) in str(refused.value)
    assert not (tmp_path / "ran").exists()
