"""Preparation of one scene before sampling: regressions, modes, whitening."""
