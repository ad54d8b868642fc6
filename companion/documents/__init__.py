"""YAML and data from outside: validated, with the place of every key, and errors in plain words."""

from companion.documents.diagnostics import did_you_mean, most_similar
from companion.documents.document import Document, TextDocument, begin_reading, validate
from companion.documents.model_schema import schema_at
from companion.documents.reading import DocumentReading
from companion.documents.sources import Given, Source, read_source

__all__ = [
    "Document",
    "DocumentReading",
    "Given",
    "Source",
    "TextDocument",
    "begin_reading",
    "did_you_mean",
    "most_similar",
    "read_source",
    "schema_at",
    "validate",
]
