"""Foreign layouts of clips, one a file, and what they share: each gives a Clip (renderer.sources opens any)."""
