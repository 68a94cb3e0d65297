"""Depth for clips without measured depth: stereo pairs, guesses, sparse points."""
