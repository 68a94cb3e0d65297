"""Live pictures for others: OpenIGTLink IMAGE messages, as 3D Slicer reads them."""
