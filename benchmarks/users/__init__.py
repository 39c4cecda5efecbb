"""Scenes as users write them: what each takes, and whether its answer is right."""
