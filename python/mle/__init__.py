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
from .comparison import Comparison, Residuals, compare, lsim, predict, resid
from .correction import (
    Advice,
    CorrectionResult,
    Message,
    StepResponse,
    advice,
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
from .examples import Example, load_example
from .interop import (
    from_state_space,
    from_systems,
    to_control,
    to_scipy,
    to_time_response,
)
from .lifecycles import LifecycleResult, lifecycle, lifecycle_options
from .model import DisturbanceModel, from_fopdt, from_step_responses, from_transfer_functions
from .mpc import Mpc
from .next_move import NextMove
from .records import read_records, to_dataframe
from .simulation import simulate, simulate_options
from .trial import Trial

# Work that an interrupt left behind ends before the interpreter does.
_atexit.register(_mle._join_left_behind)

__all__ = [
    "Advice",
    "CancelledError",
    "Comparison",
    "CorrectionResult",
    "DisturbanceModel",
    "Error",
    "Example",
    "FileAccessError",
    "InvalidInputError",
    "LifecycleResult",
    "Message",
    "MissingFileError",
    "Mpc",
    "NextMove",
    "NotUsableError",
    "Plant",
    "ProcessModel",
    "Record",
    "Residuals",
    "StateSpaceModel",
    "StepResponse",
    "StepResponseModel",
    "StudyResult",
    "Trial",
    "__version__",
    "advice",
    "compare",
    "correct",
    "correct_options",
    "from_fopdt",
    "from_state_space",
    "from_step_responses",
    "from_systems",
    "from_transfer_functions",
    "lifecycle",
    "lifecycle_options",
    "load_example",
    "lsim",
    "predict",
    "read_records",
    "resid",
    "simulate",
    "simulate_options",
    "study",
    "to_control",
    "to_dataframe",
    "to_scipy",
    "to_time_response",
]
