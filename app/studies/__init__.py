"""Sweeps that grow while one watches; no page import."""
