"""Serving: admission of sessions, the websocket, validation of messages, security, limits."""
