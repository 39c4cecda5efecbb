"""Other programs' files: what they wrote, read into a scene, and drawings, motions and tables for them.

Writers get records and arrays in SI units and radians, and return what a file holds.
"""
