"""Files to take away: parameters, tables, scripts, reports; no page import."""
