"""Tables that spreadsheets open."""

from __future__ import annotations

import csv

from app.files.csv_table import csv_table


def test_what_is_not_utf8_in_a_name_is_a_question_mark() -> None:
    assert csv_table(["clip"], [{"clip": "caf\udce9.png"}]) == b"clip\r\ncaf?.png\r\n"


def test_a_text_is_no_formula_and_numbers_are_numbers() -> None:
    rows = [
        {"clip": "=cmd()|x.png", "psnr": -3.5, "count": 2},
        {"clip": "-1.png", "psnr": float("nan")},
        {"clip": "plain, 2.png", "psnr": None, "count": True},
    ]
    first, second, third = csv.DictReader(csv_table(["clip", "psnr", "count"], rows).decode().splitlines())
    assert first == {"clip": "'=cmd()|x.png", "psnr": "-3.5", "count": "2"}
    assert second == {"clip": "'-1.png", "psnr": "", "count": ""}
    assert third == {"clip": "plain, 2.png", "psnr": "", "count": "True"}
