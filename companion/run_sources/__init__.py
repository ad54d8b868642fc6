"""What a companion flies next: its only mission, or those that operators start."""
