"""DICOM objects: stills, frame by frame and as a video stream. pydicom reads and decodes them."""
