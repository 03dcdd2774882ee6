"""What the paper says, figure by figure, and what this engine finds: claims that are checked whenever they are asked.

"Penalty-regularization of a dissipative vibro-impacting system". Nothing that is found is written down here: `CLAIMS`
holds sentences and ways to check them. The page, ``vibroscope paper`` and the tests use the same list. No panel import.
"""

from vibroscope.app.paper.claim import VERDICTS, Claim, Finding, Orbits, Plane, Times, as_dict, tally
from vibroscope.app.paper.motions import MOTIONS
from vibroscope.app.paper.penalties import PENALTIES
from vibroscope.app.paper.planes import PLANES

CLAIMS: dict[str, Claim] = {
    claim.key: claim for claim in sorted(MOTIONS + PENALTIES + PLANES, key=lambda claim: (claim.figure, claim.key))
}

__all__ = ["CLAIMS", "VERDICTS", "Claim", "Finding", "Orbits", "Plane", "Times", "as_dict", "tally"]
