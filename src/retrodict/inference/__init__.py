"""Bayesian inference: the posterior as a function, its coordinates, the draws and their checks."""

from retrodict.inference.errors import Interrupted, Unanswerable

__all__ = ["Interrupted", "Unanswerable"]
