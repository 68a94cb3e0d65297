"""The fonts of the window: its own, and for other scripts those of the system, as far as they are there."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

from imgui_bundle import hello_imgui, imgui

from app.gui.style.theme import FONT_SIZE

OWN: Final = "fonts/Roboto/Roboto-Regular.ttf"
OF_SYSTEM: Final = {
    "linux": (
        "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/noto-cjk/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/google-noto-sans-cjk-fonts/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/google-noto-cjk/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc",
        "/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf",
    ),
    "win32": (
        "C:/Windows/Fonts/YuGothR.ttc",
        "C:/Windows/Fonts/msyh.ttc",
        "C:/Windows/Fonts/malgun.ttf",
    ),
    "darwin": (
        "/System/Library/Fonts/Hiragino Sans GB.ttc",
        "/System/Library/Fonts/AppleSDGothicNeo.ttc",
    ),
}
"""By platform, of Chinese, Japanese and Korean: names of files and patients are written so."""

WIDER: Final = 1.2
"""Times the size of Roboto, beside whose capitals these letters would look small."""


def load_fonts() -> None:
    """Roboto with icons, from imgui-bundle's own assets (Apache 2.0 and OFL), then the system's; a letter is
    taken from the first that has it."""
    hello_imgui.load_font_ttf_with_font_awesome_icons(OWN, FONT_SIZE)
    for path in of_system(sys.platform):
        config = imgui.ImFontConfig()
        config.extra_size_scale = WIDER
        merged = hello_imgui.FontLoadingParams(
            merge_to_last_font=True, inside_assets=False, font_config=config
        )
        hello_imgui.load_font(str(path), FONT_SIZE, merged)


def of_system(platform: str) -> tuple[Path, ...]:
    """Those that are there: of Linux one, which has all three scripts, elsewhere one for each."""
    found = tuple(path for path in map(Path, OF_SYSTEM.get(platform, ())) if path.is_file())
    return found[:1] if platform == "linux" else found
