"""Motions of a system: their description, type, steady cycles, stability and coexistence."""
