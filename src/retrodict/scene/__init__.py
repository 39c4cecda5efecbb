"""What was measured: records in SI, the scene file at the door, defaults with their sources."""
