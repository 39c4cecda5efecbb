"""The tables of a scene file as they may be written, a module for each part of the file."""
