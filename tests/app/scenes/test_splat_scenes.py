"""What is told of splat files when they are opened: none in them, or moments of another render mode."""

from __future__ import annotations

from pathlib import Path

from app.scenes.scene import open_scene
from renderer import write_splats
from tests.renderer.splat_files.files import gaussians


def test_a_file_without_splats_shows_nothing(tmp_path: Path) -> None:
    write_splats(tmp_path / "a.ply", gaussians(0))
    assert open_scene(tmp_path / "a.ply").notices == ("no Gaussians to render: nothing is seen",)


def test_moments_of_another_mode_than_the_first_are_told(tmp_path: Path) -> None:
    for index, mode in enumerate(("default", "mip", "mip")):
        write_splats(tmp_path / f"a{index}.ply", gaussians(9), "mip" if mode == "mip" else "default")
    scene = open_scene(tmp_path)
    assert scene.mode == "default"
    assert scene.notices == ("all are drawn as the first, default: 2 of 3 say another mode",)
    write_splats(tmp_path / "a0.ply", gaussians(9), "mip")
    assert open_scene(tmp_path).notices == ()
