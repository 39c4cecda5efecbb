"""The posterior density of a model and a scene, compiled and kept on disk."""
