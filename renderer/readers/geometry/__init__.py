"""Depth maps, poses, points and tables of numbers, as the files of data sets hold them."""
