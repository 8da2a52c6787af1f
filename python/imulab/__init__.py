"""The laboratory for inertial measurement units: calibrate, compensate, and say how sure the result is.

    import imulab
    recording = imulab.Recording.from_arrays(t, gyro, accel)          # s, rad/s, m/s^2; (N,), (N, 3), (N, 3)
    c = imulab.calibrate(recording, site=imulab.Site(latitude_deg=47.4), method="handheld")
    print(c)                                                          # verdict, what was reached, every coefficient
    rate, force = c.apply(gyro, accel)

All values are SI, arrays are N x 3 with a row a sample. Wrong input raises `Error`; data that do not support what was asked, `Unsupported`.
"""

import atexit as _atexit

from . import _imulab
from ._calibration import Calibration, Coefficient, Terms, Triad, import_calibration, read_calibration
from ._fleet import Fleet, FleetStatistics
from ._imulab import Error, Unsupported
from ._live import Live
from ._recording import Recording
from ._results import Budget, Comparison, Inspection, Navigation, Noise, Plan, Prediction, Result, Solution, Verification, VerifiedFile
from ._session import Session, Site, procedure, read_session
from ._text import DataWarning
from ._verbs import (
    Flight,
    Simulation,
    allan_deviation,
    budget,
    calibrate,
    compare,
    compensate,
    export_targets,
    inspect,
    methods,
    navigate,
    noise,
    plan,
    predict,
    read_recording,
    simulate,
    trajectory,
    verify,
)

__version__: str = _imulab.software.removeprefix("imulab ")

__all__ = [
    "Budget",
    "Calibration",
    "Coefficient",
    "Comparison",
    "DataWarning",
    "Error",
    "Fleet",
    "FleetStatistics",
    "Flight",
    "Inspection",
    "Live",
    "Navigation",
    "Noise",
    "Plan",
    "Prediction",
    "Recording",
    "Result",
    "Session",
    "Simulation",
    "Site",
    "Solution",
    "Terms",
    "Triad",
    "Unsupported",
    "Verification",
    "VerifiedFile",
    "allan_deviation",
    "budget",
    "calibrate",
    "compare",
    "compensate",
    "export_targets",
    "import_calibration",
    "inspect",
    "methods",
    "navigate",
    "noise",
    "plan",
    "predict",
    "procedure",
    "read_calibration",
    "read_recording",
    "read_session",
    "simulate",
    "trajectory",
    "verify",
]

for _name in __all__:  # in messages and in help, the package's own names
    if getattr(globals()[_name], "__module__", "").startswith("imulab."):
        globals()[_name].__module__ = "imulab"

Error.__doc__ = "The input is wrong: the text says where, what is wrong, and what was expected."
Unsupported.__doc__ = "The input is well formed, but the data do not support what was asked."

_atexit.register(_imulab.wait_for_abandoned)  # of work that was interrupted
