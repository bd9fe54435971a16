"""The people who walk through the scenes."""

from .assemble import files  # noqa: F401
