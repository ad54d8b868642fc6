"""YAML from outside: validated, with the place of every key, and errors in plain words."""

from companion.documents.diagnostics import did_you_mean
from companion.documents.document import Document, validate

__all__ = ["Document", "did_you_mean", "validate"]
