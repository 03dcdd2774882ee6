"""View Pulse or record, of the tab One impact."""
