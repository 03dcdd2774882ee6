"""What a search for K, D and Δτ asks and finds, for tests of the page."""

from vibroscope.app.explorer.state import Setting
from vibroscope.engine import Recommendation
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial

SETTING = Setting()
WORSE = Trial(NewmarkSetting(2000.0, 7.0, 500), 0.3, 0.31, 500.0)
TRIAL = Trial(NewmarkSetting(10500.0, 15.8, 5793), 0.0486, 0.0494, 5793.0)


def found_for(question, *, met=True, best=TRIAL, front=(TRIAL,), joint=0.0, reason=""):
    system, (eta, *_), reference, located, tolerance, *_ = question
    return Recommendation(
        system=system,
        eta=eta,
        reference=reference,
        tolerance=tolerance,
        located=located,
        met=met,
        best=best,
        front=front,
        joint_damping=joint,
        reason=reason,
    )
