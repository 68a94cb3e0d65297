"""An exported file from its provenance: what that says, its sources, the file again, how far both differ."""
