"""DICOM objects that are written: what they say of a person and of their making, and their pixels."""
