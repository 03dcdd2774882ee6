"""The claims of the paper "Penalty-regularization of a dissipative vibro-impacting system", and how each is checked.

`CLAIMS` holds sentences and checks, no results: a claim is checked by running the engine whenever it is asked for. The
page, ``vibroscope paper`` and the tests use the same list. No panel import.
"""

from vibroscope.app.paper.claims import VERDICTS, Claim, Finding, as_dict, count_verdicts
from vibroscope.app.paper.penalty_claims import PENALTY_CLAIMS
from vibroscope.app.paper.plane_claims import PLANE_CLAIMS
from vibroscope.app.paper.reference_claims import REFERENCE_CLAIMS

_ALL = REFERENCE_CLAIMS + PENALTY_CLAIMS + PLANE_CLAIMS
CLAIMS: dict[str, Claim] = {claim.key: claim for claim in sorted(_ALL, key=lambda claim: (claim.figure, claim.key))}

__all__ = ["CLAIMS", "VERDICTS", "Claim", "Finding", "as_dict", "count_verdicts"]
