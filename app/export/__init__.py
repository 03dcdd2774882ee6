"""What a user takes away: parameters, tables, scripts, reports; no page import."""
