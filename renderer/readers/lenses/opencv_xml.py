"""What OpenCV stores as XML (`cv::FileStorage`), by its names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

ROOT = "opencv_storage"
MATRIX = "opencv-matrix"


def opencv_xml(text: str) -> Mapping[str, Any]:
    """Its values as text, those of matrices as mappings whose "data" is their numbers in rows.

    Raises ValueError: no XML, or of another program.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"expected OpenCV's XML, got {error}") from error
    if root.tag != ROOT:
        raise ValueError(f"expected OpenCV's XML ({ROOT}), got {root.tag}")
    return {each.tag: _value(each) for each in root}


def _value(node: ElementTree.Element) -> Any:
    if node.get("type_id") != MATRIX:
        return (node.text or "").strip()
    return {"data": (node.findtext("data") or "").split()}
