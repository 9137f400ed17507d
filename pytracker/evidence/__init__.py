"""Pixels to evidence, frame by frame."""
