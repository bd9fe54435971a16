"""The public hall."""

from .assemble import files  # noqa: F401
