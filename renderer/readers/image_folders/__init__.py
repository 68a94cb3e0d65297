"""Folders of images: recordings and stills, and what lies beside their frames."""
