"""YAML from outside: validated, with the place of every key, and problems in plain words."""

from companion.documents.document import Document, validate
from companion.documents.problems import did_you_mean

__all__ = ["Document", "did_you_mean", "validate"]
