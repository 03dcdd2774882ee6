"""What a search for K, D and Δτ asks and finds, for tests of the page."""

from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Recommendation
from vibroscope.engine.recommendation.contacts import Contacts
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial

SETTING = Setting()
WORSE = Trial(NewmarkSetting(2000.0, 7.0, 500), 0.3, 0.31, 500.0)
CONTACTS = Contacts(0.52, 0.5, 700.0, 640.0, 61.0)
TRIAL = Trial(NewmarkSetting(10500.0, 15.8, 5793), 0.0486, 0.0494, 5793.0, CONTACTS)
RANGES = {"stiffness": (9023.4, 12345.0), "damping": (14.0, 17.0)}


def found_for(question, *, met=True, best=TRIAL, front=(TRIAL,), joint=0.0, reason=""):
    return Recommendation(
        question=question.search,
        eta=question.search.etas[-1],
        met=met,
        best=best,
        ranges=RANGES if met else {},
        front=front,
        joint_damping=joint,
        reason=reason,
    )
