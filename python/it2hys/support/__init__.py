"""Helpers that know nothing of the field: files written whole, processes, progress, TOML keys."""
