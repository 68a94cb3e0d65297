"""Live pictures: captured, enhanced and recorded as they come, the newest first. No window, no torch."""
