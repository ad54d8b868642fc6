"""YAML and data from outside: validated, with the place of every key, problems in plain words."""

from companion.documents.document import Document, TextDocument, validate
from companion.documents.problems import did_you_mean

__all__ = ["Document", "TextDocument", "did_you_mean", "validate"]
