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
from ._calibration import Calibration as Calibration, Coefficient as Coefficient, Terms as Terms, Triad as Triad
from ._calibration import import_calibration as import_calibration, read_calibration as read_calibration
from ._fleet import Fleet as Fleet, FleetStatistics as FleetStatistics
from ._imulab import Error as Error, Unsupported as Unsupported
from ._live import Live as Live
from ._recording import Recording as Recording
from ._results import Budget as Budget, Comparison as Comparison, Extrinsics as Extrinsics, Inspection as Inspection, Mounting as Mounting
from ._results import Flight as Flight, Navigation as Navigation, Noise as Noise, Plan as Plan, Prediction as Prediction, Result as Result
from ._results import Simulation as Simulation, Solution as Solution, Verification as Verification, VerifiedFile as VerifiedFile
from ._session import Session as Session, Site as Site, procedure as procedure, read_session as read_session
from ._text import DataWarning as DataWarning
from ._verbs import allan_deviation as allan_deviation, budget as budget, calibrate as calibrate
from ._verbs import calibrate_jointly as calibrate_jointly, extrinsics as extrinsics
from ._verbs import compare as compare, compensate as compensate, export_targets as export_targets, inspect as inspect, methods as methods
from ._verbs import navigate as navigate, noise as noise, plan as plan, predict as predict, read_recording as read_recording
from ._verbs import simulate as simulate, trajectory as trajectory, verify as verify

__version__: str = _imulab.software.removeprefix("imulab ")

__all__ = sorted(_name for _name in globals() if not _name.startswith("_"))

for _name in __all__:  # in messages and in help, the package's own names
    if getattr(globals()[_name], "__module__", "").startswith("imulab."):
        globals()[_name].__module__ = "imulab"

Error.__doc__ = "The input is wrong: the text says where, what is wrong, and what was expected."
Unsupported.__doc__ = "The input is well formed, but the data do not support what was asked."

_atexit.register(_imulab.wait_for_abandoned)  # of work that was interrupted
