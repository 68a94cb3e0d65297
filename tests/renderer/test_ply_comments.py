from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from renderer.ply_comments import LONGEST, joined, split
from renderer.ply_elements import read_ply
from renderer.splat_files.inria_ply import ply_bytes
from tests.renderer.splat_files.files import gaussians

WORDS = st.text(st.sampled_from('ab  \\"ü\n,{'), max_size=700)


@given(st.dictionaries(WORDS, WORDS, max_size=3))
def test_a_text_of_any_length_comes_back_from_short_lines(facts: dict[str, str]) -> None:
    content = ply_bytes(gaussians(1), "mip", split("word", json.dumps(facts)))
    header = content[: content.index(b"end_header")].split(b"\n")
    assert max(len(line) for line in header) <= LONGEST
    text = joined("word", read_ply(content).comments)
    assert text is not None
    assert json.loads(text) == facts


def test_lines_are_of_the_text_that_they_go_on_with() -> None:
    comments = ("SplatRenderMode: mip", "word one", "word+  two", "other+ three", "word+ four")
    assert joined("word", comments) == "one two"
    assert joined("other", comments) is None


def test_a_line_that_makes_other_programs_abort_is_never_written() -> None:
    with pytest.raises(ValueError, match="up to 240 bytes, got 1008"):
        ply_bytes(gaussians(1), "default", ["x" * 1000])
