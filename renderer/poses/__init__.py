"""Camera poses from the frames of a clip with depth."""
