"""Presets that come with exidyn: one TOML file each."""
