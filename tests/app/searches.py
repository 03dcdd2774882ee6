"""What a search for K, D and Δτ asks and finds, for tests of the page."""

from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Recommendation
from vibroscope.engine.recommendation.contacts import Contacts, Tolerances
from vibroscope.engine.recommendation.recommend import scheme_of
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial

SETTING = Setting()
WORSE = Trial(NewmarkSetting(2000.0, 7.0, 500), 0.3, 0.31, 500.0)
CONTACTS = Contacts(0.52, 0.5, 700.0, 640.0, 61.0)
TRIAL = Trial(NewmarkSetting(10500.0, 15.8, 5793), 0.0486, 0.0494, 5793.0, CONTACTS)
RANGES = {"stiffness": (9023.4, 12345.0), "damping": (14.0, 17.0)}


def found_for(question, *, met=True, best=TRIAL, front=(TRIAL,), joint=0.0, reason=""):
    system, (eta, *_), reference, located, tolerance, *_ = question
    return Recommendation(
        system=system,
        eta=eta,
        reference=reference,
        tolerances=Tolerances(tolerance),
        located=located,
        met=met,
        best=best,
        ranges=RANGES if met else {},
        front=front,
        joint_damping=joint,
        reason=reason,
        scheme=scheme_of(None, located),
    )
