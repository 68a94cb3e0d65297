"""Reproduces an exported file: reads its provenance, finds its sources, makes it and compares the two."""
