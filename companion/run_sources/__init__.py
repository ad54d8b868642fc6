"""Decides what a companion flies next: its only mission, or missions that operators start."""
