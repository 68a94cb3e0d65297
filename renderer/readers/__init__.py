"""Foreign layouts of clips, one a file, and what they share: each gives a Clip. See renderer.sources."""
