"""Builds the example garments: forms, meshes, patterns and their USD stages."""
