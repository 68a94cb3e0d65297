"""Data sets, one layout a file: folders that are one clip, with poses, calibration, masks or depth."""
