"""The token of a page: it names the session that its websocket may open, for some minutes.

Its age is what the monotonic clock says: the time of day may jump by a year when it is set. Another replica's token has
no other age than the time of day in it, so that a jump there costs the visitors of that moment one reload.
"""

from __future__ import annotations

import secrets
import time

from bokeh.util.token import check_token_signature, generate_jwt_token, get_token_payload

TOKEN_SECONDS = 300
PROCESS = secrets.token_hex(8)  # whose monotonic clock it is


def make_token(session_id: str, key: bytes) -> str:
    """Return the signed token of a session."""
    made = {"process": PROCESS, "made": time.monotonic()}
    return generate_jwt_token(
        session_id, secret_key=key, signed=True, expiration=TOKEN_SECONDS, extra_payload={"vibroscope": made}
    )


def is_valid_token(token: str, key: bytes) -> bool:
    """Return whether this server, or a replica with the same key, signed the token and it has not expired."""
    try:
        return check_token_signature(token, secret_key=key, signed=True) and not _has_expired(get_token_payload(token))
    except (ValueError, KeyError, TypeError):  # this is no token
        return False


def _has_expired(payload: dict) -> bool:
    own = payload["vibroscope"]
    if own["process"] == PROCESS:
        return time.monotonic() - own["made"] > TOKEN_SECONDS
    return time.time() > payload["session_expiry"]
