"""Run-out models: how the vehicles move from the impact to rest."""
