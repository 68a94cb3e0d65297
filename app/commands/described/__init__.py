"""What a path is read as, and what can be done with it, without doing it: `vesselsplat info PATH`."""
