"""YAML and data from outside: validated, with the place of every key, errors in plain words."""

from companion.documents.diagnostics import did_you_mean
from companion.documents.document import Document, TextDocument, validate

__all__ = ["Document", "TextDocument", "did_you_mean", "validate"]
