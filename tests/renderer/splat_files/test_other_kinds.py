"""Files that hold no splats that are read here, by their names or what is in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from renderer.splat_files import SplatFileError, is_named_as_splats, read_splats
from tests.renderer.splat_files.files import zipped


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.ksplat", bytes(4096), "version 0.0 and level 0: convert it to .ply"),
        ("a.sog", zipped("meta.json"), "version 2, got 1: convert it to .ply"),
        ("a.sog", zipped("lod-meta.json"), "a zip archive"),
        ("a.sog", b"nonsense", "damaged"),
        ("a.splat", b"", "an empty file"),
        ("a.splat", b"\x89PNG\r\n\x1a\n" + bytes(88), "a PNG image"),
        ("meta.json", b'{"version": 3, "means": {}, "sh0": {}}', "version 2, got 3: convert it to .ply"),
        ("lod-meta.json", b'{"lodLevels": 3}', "one level of detail, got several: convert"),
        ("model.safetensors", bytes(9), "the folder of its run"),
    ],
)
def test_other_formats_are_named_with_what_to_do(
    tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SplatFileError, match=said) as caught:
        read_splats(path)
    assert str(caught.value).endswith(name)
    assert is_named_as_splats(path) == (name != "model.safetensors")


def test_a_folder_is_splats_only_as_an_unpacked_one(tmp_path: Path) -> None:
    assert not is_named_as_splats(tmp_path)
    (tmp_path / "meta.json").write_text('{"fx": 3}')
    assert not is_named_as_splats(tmp_path)
    (tmp_path / "meta.json").write_text('{"means": {}, "sh0": {}}')
    assert is_named_as_splats(tmp_path)
    with pytest.raises(SplatFileError, match="a SOG of version 2, got 1"):
        read_splats(tmp_path)
