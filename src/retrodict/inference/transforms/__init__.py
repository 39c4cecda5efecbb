"""Bijections from sampled coordinates to the unknowns of a model, with their log determinants."""
