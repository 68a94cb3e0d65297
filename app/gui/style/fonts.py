"""The fonts of the window: its own, and for other scripts those of the system, as far as they are there."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

from imgui_bundle import hello_imgui, imgui

from app.gui.style.theme import FONT_SIZE

OWN: Final = "fonts/Roboto/Roboto-Regular.ttf"
WIDER: Final = 1.2
"""Times the size of Roboto, beside whose capitals Chinese, Japanese and Korean letters would look small."""
Choice = tuple[float, tuple[str, ...]]
"""How large beside Roboto, and fonts of which the first that is there does."""
OF_SYSTEM: Final[dict[str, tuple[Choice, ...]]] = {
    "linux": (
        (
            WIDER,
            (
                "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
                "/usr/share/fonts/noto-cjk/NotoSansCJK-Regular.ttc",
                "/usr/share/fonts/google-noto-sans-cjk-fonts/NotoSansCJK-Regular.ttc",
                "/usr/share/fonts/google-noto-cjk/NotoSansCJK-Regular.ttc",
                "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
                "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
            ),
        ),
        (
            1.0,
            (
                "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
                "/usr/share/fonts/TTF/DejaVuSans.ttf",
            ),
        ),
    ),
    "win32": (
        (WIDER, ("C:/Windows/Fonts/YuGothR.ttc",)),
        (WIDER, ("C:/Windows/Fonts/msyh.ttc",)),
        (WIDER, ("C:/Windows/Fonts/malgun.ttf",)),
        (1.0, ("C:/Windows/Fonts/segoeui.ttf",)),
    ),
    "darwin": (
        (WIDER, ("/System/Library/Fonts/Hiragino Sans GB.ttc",)),
        (WIDER, ("/System/Library/Fonts/AppleSDGothicNeo.ttc",)),
        (1.0, ("/System/Library/Fonts/Supplemental/Arial Unicode.ttf",)),
    ),
}
"""By platform, of Chinese, Japanese and Korean, then of Hebrew, Arabic and more, letter by letter: names of
files and patients are written so."""


def load_fonts() -> None:
    """Roboto with icons, from imgui-bundle's own assets (Apache 2.0 and OFL), then the system's; a letter is
    taken from the first that has it."""
    hello_imgui.load_font_ttf_with_font_awesome_icons(OWN, FONT_SIZE)
    for scale, path in of_system(sys.platform):
        config = imgui.ImFontConfig()
        config.extra_size_scale = scale
        merged = hello_imgui.FontLoadingParams(
            merge_to_last_font=True, inside_assets=False, font_config=config
        )
        hello_imgui.load_font(str(path), FONT_SIZE, merged)


def of_system(platform: str) -> tuple[tuple[float, Path], ...]:
    """Those that are there, and how large beside Roboto: of each choice one."""
    choices = OF_SYSTEM.get(platform, ())
    found = ((scale, [path for path in map(Path, names) if path.is_file()]) for scale, names in choices)
    return tuple((scale, paths[0]) for scale, paths in found if paths)
