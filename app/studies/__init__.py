"""Studies that a page shows while they grow: the study of a setting, and what is shown of it. No page import."""
