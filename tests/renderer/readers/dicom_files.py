"""Small DICOM objects of every kind that is read, made by pydicom."""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from PIL import Image
from pydicom import Dataset
from pydicom.dataset import FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.pixels.processing import convert_color_space
from pydicom.uid import (
    MPEG4HP41,
    UID,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGBaseline8Bit,
    RLELossless,
)

STILL, VIDEO = "1.2.840.10008.5.1.4.1.1.77.1.1", "1.2.840.10008.5.1.4.1.1.77.1.1.1"


def picture(width: int = 64, height: int = 48, seed: int = 0) -> np.ndarray:
    """(H, W, 3) RGB, smooth, with all levels."""
    noise = np.random.default_rng(seed).normal(0, 1, (height, width, 3))
    smooth = cv2.GaussianBlur(noise, (0, 0), 3)
    low, high = smooth.min(), smooth.max()
    return ((smooth - low) / (high - low) * 255).round().astype(np.uint8)


def labelled(kind: str = STILL, syntax: UID = ExplicitVRLittleEndian) -> Dataset:
    """Of a person, without a picture."""
    made = Dataset()
    made.file_meta = FileMetaDataset()
    made.file_meta.TransferSyntaxUID = syntax
    made.SOPClassUID = made.file_meta.MediaStorageSOPClassUID = UID(kind)
    made.SOPInstanceUID = made.file_meta.MediaStorageSOPInstanceUID = UID("2.25.11")
    made.StudyInstanceUID, made.SeriesInstanceUID = UID("2.25.22"), UID("2.25.33")
    made.SpecificCharacterSet = "ISO_IR 100"
    made.PatientName, made.PatientID, made.PatientBirthDate = "Müller^Hanna", "PID-4711", "19500102"
    made.StudyDate, made.StudyTime, made.AccessionNumber = "20240501", "101500", "ACC-A77"
    made.InstitutionName, made.Modality, made.InstanceNumber = "Clinic", "ES", 3
    return made


def with_pixels(made: Dataset, pixels: np.ndarray, photometric: str = "RGB", bits: int = 8) -> Dataset:
    """(H, W), (H, W, 3) or (N, H, W, 3)."""
    samples = 3 if pixels.shape[-1] == 3 else 1
    shape = pixels.shape[:-1] if samples == 3 else pixels.shape
    made.Rows, made.Columns = shape[-2:]
    made.SamplesPerPixel, made.PhotometricInterpretation = samples, photometric
    made.BitsAllocated, made.BitsStored, made.HighBit = 8 * pixels.dtype.itemsize, bits, bits - 1
    made.PixelRepresentation = 0
    if samples == 3:
        made.PlanarConfiguration = 0
    if len(shape) == 3:
        made.NumberOfFrames = shape[0]
    made.PixelData = pixels.tobytes() + bytes(pixels.nbytes % 2)
    return made


def compressed(made: Dataset, frames: Sequence[bytes], fragments: int = 1) -> Dataset:
    """With these in place of its pixels."""
    padded = [frame + bytes(len(frame) % 2) for frame in frames]
    made.PixelData = encapsulate(padded, fragments_per_frame=fragments)
    made["PixelData"].VR = "OB"
    return made


def saved(made: Dataset, path: Path) -> Path:
    made.save_as(path, enforce_file_format=True)
    return path


def encoded(image: np.ndarray, kind: str, **settings: Any) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, kind, **settings)
    return buffer.getvalue()


def lossless(image: np.ndarray, codec: str, form: str) -> bytes:
    """One frame as FFmpeg's encoder of that name makes it of pixels of that form."""
    encoder: Any = av.CodecContext.create(codec, "w")
    encoder.height, encoder.width, encoder.pix_fmt = *image.shape[:2], form
    encoder.time_base = Fraction(1, 25)
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), form)
    return b"".join(bytes(packet) for packet in (*encoder.encode(frame), *encoder.encode(None)))


def lossless_of(grey: np.ndarray, precision: int) -> bytes:
    """(H, W) of so many bits as JPEG Lossless (ITU-T T.81, annex H): each value less that to its left, in a
    code of five bits for its length."""
    predicted = np.empty(grey.shape, np.int64)
    predicted[:, 1:], predicted[1:, 0], predicted[0, 0] = grey[:, :-1], grey[:-1, 0], 1 << (precision - 1)
    bits = ""
    for apart in (grey.astype(np.int64) - predicted).ravel().tolist():
        length = abs(apart).bit_length()
        bits += f"{length:05b}"
        bits += f"{apart if apart > 0 else apart + (1 << length) - 1:0{length}b}" if length else ""
    bits += "1" * (-len(bits) % 8)
    data = int(bits, 2).to_bytes(len(bits) // 8).replace(b"\xff", b"\xff\0")
    codes = b"\xff\xc4" + struct.pack(">HB", 36, 0) + bytes([0, 0, 0, 0, 17, *[0] * 11, *range(17)])
    frame = b"\xff\xc3" + struct.pack(">HBHHBBBB", 11, precision, *grey.shape, 1, 1, 0x11, 0)
    scan = b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 1, 0, 0)
    return b"\xff\xd8" + codes + frame + scan + data + b"\xff\xd9"


def stills(image: np.ndarray) -> dict[str, tuple[Dataset, int]]:
    """Objects that hold `image` or its grey, each with the grey levels by which it may be off."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    ybr = convert_color_space(image, "RGB", "YBR_FULL")
    halved = np.stack([ybr[:, 0::2, 0], ybr[:, 1::2, 0], ybr[:, 0::2, 1], ybr[:, 0::2, 2]], axis=-1)
    planes = with_pixels(labelled(), image)
    planes.PlanarConfiguration, planes.PixelData = 1, image.transpose(2, 0, 1).tobytes()
    sparse = with_pixels(labelled(), ybr, "YBR_FULL_422")
    sparse.PixelData = halved.tobytes()
    runs = with_pixels(labelled(), image)
    runs.compress(RLELossless, generate_instance_uid=False)
    jpeg = with_pixels(labelled(syntax=JPEGBaseline8Bit), image, "YBR_FULL_422")
    wavelets = with_pixels(labelled(syntax=JPEG2000Lossless), image, "YBR_RCT")
    whole = {"no_jp2": True, "mct": 1, "irreversible": False}
    return {
        "rgb": (with_pixels(labelled(), image), 0),
        "implicit": (with_pixels(labelled(syntax=ImplicitVRLittleEndian), image), 0),
        "planes": (planes, 0),
        "ybr": (with_pixels(labelled(), ybr, "YBR_FULL"), 1),
        "ybr 422": (sparse, 40),
        "rle": (runs, 0),
        "jpeg": (compressed(jpeg, [encoded(image, "JPEG", quality=98, subsampling=1)]), 40),
        "jpeg 2000": (compressed(wavelets, [encoded(image, "JPEG2000", **whole)]), 0),
        "rgb 16": (with_pixels(labelled(), image.astype(np.uint16) * 257, "RGB", 16), 0),
        "grey": (with_pixels(labelled(), grey, "MONOCHROME2"), 0),
        "inverted": (with_pixels(labelled(), 255 - grey, "MONOCHROME1"), 0),
        "grey 12": (with_pixels(labelled(), (grey.astype(np.uint32) * 4095 // 255).astype(np.uint16),
                                "MONOCHROME2", 12), 0),
    }  # fmt: skip


def video_file(
    path: Path, frames: Sequence[np.ndarray], kind: str | None = None, *, sound: bool = False
) -> bytes:
    """H.264, 25 frames a second, in the container of the suffix or of this kind."""
    with av.open(str(path), "w", format=kind) as container:
        stream = container.add_stream("libx264", rate=25, options={"crf": "10"})
        stream.width, stream.height, stream.pix_fmt = frames[0].shape[1], frames[0].shape[0], "yuv420p"
        track = container.add_stream("aac", rate=44100) if sound else None
        for frame in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, "rgb24")))
        container.mux(stream.encode())
        if track is not None:
            tone = np.sin(np.arange(8192) / 20).astype(np.float32)[None]
            heard = av.AudioFrame.from_ndarray(tone, "fltp", "mono")
            heard.rate, heard.pts = 44100, 0
            container.mux((*track.encode(heard), *track.encode(None)))
    return path.read_bytes()


def video(content: bytes, size: tuple[int, int], frames: int, frame_time: str, fragments: int = 1) -> Dataset:
    """A video endoscopic image that holds that file; milliseconds a frame."""
    made = with_pixels(labelled(VIDEO, MPEG4HP41), np.zeros((*size[::-1], 3), np.uint8), "YBR_PARTIAL_420")
    made.NumberOfFrames, made.FrameTime = frames, frame_time
    return compressed(made, [content], fragments)
