"""Tab Time step."""
