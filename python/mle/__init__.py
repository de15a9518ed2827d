"""Model Life Extension: correct a process model from routine closed-loop records.

    import mle
    result = mle.correct("column.json", frame)      # a pandas data frame, or files
    print(result.decision, result.verdict)
    result.corrected                                # the model for use
    result.report("page.html")

docs/python.md has a tutorial and the list of what there is.
"""

import atexit as _atexit

from . import _mle
from ._mle import (
    Plant,
    ProcessModel,
    Record,
    StateSpaceModel,
    StepResponseModel,
    __version__,
)
from .campaigns import StudyResult, study
from .correction import (
    CorrectionResult,
    Message,
    StepResponse,
    correct,
    correct_options,
)
from .errors import (
    CancelledError,
    Error,
    FileAccessError,
    InvalidInputError,
    MissingFileError,
    NotUsableError,
)
from .interop import from_state_space, from_systems, to_control, to_scipy
from .lifecycles import LifecycleResult, lifecycle, lifecycle_options
from .model import from_fopdt, from_step_responses, from_transfer_functions
from .mpc import Mpc
from .records import read_records, to_dataframe
from .simulation import simulate, simulate_options

# Work that an interrupt left behind ends before the interpreter does.
_atexit.register(_mle._join_left_behind)

__all__ = [
    "CancelledError",
    "CorrectionResult",
    "Error",
    "FileAccessError",
    "InvalidInputError",
    "LifecycleResult",
    "Message",
    "MissingFileError",
    "Mpc",
    "NotUsableError",
    "Plant",
    "ProcessModel",
    "Record",
    "StateSpaceModel",
    "StepResponse",
    "StepResponseModel",
    "StudyResult",
    "__version__",
    "correct",
    "correct_options",
    "from_fopdt",
    "from_state_space",
    "from_step_responses",
    "from_systems",
    "from_transfer_functions",
    "lifecycle",
    "lifecycle_options",
    "read_records",
    "simulate",
    "simulate_options",
    "study",
    "to_control",
    "to_dataframe",
    "to_scipy",
]
