"""The equations of motion and the contact laws of everything compiled; the impact law is in `..event_driven.events`."""
