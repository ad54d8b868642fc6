"""YAML and data from outside: validated, with the place of every key, errors in plain words."""

from companion.documents.diagnostics import did_you_mean, most_similar
from companion.documents.document import Document, TextDocument, validate
from companion.documents.gathering import MistakeGathering
from companion.documents.sources import Given, Source, read_source

__all__ = [
    "Document",
    "Given",
    "MistakeGathering",
    "Source",
    "TextDocument",
    "did_you_mean",
    "most_similar",
    "read_source",
    "validate",
]
