"""What follows: the posterior as a function, its coordinates, the draws and the verdict on them."""

from retrodict.inference.errors import Interrupted, Unanswerable

__all__ = ["Interrupted", "Unanswerable"]
