"""Frames of a video file by number: PyAV's decoder and OpenCV's, and what both have to know of a file."""
