"""Types of keywords, for editors and type checkers: by scripts/python_keywords."""

from typing import Any, Literal, Sequence, TypedDict, Union

Numbers = Union[float, Sequence[float]]


class MpcOptions(TypedDict, total=False):
    """Of :func:`Mpc`."""

    control_period: Numbers
    prediction_horizon: Numbers
    control_horizon: Numbers
    output_weight: Numbers
    move_weight: Numbers
    disturbance_variance_ratio: Numbers
    min_input: Any
    max_input: Any
    max_move: Any
    min_output: Any
    max_output: Any
    output_limit_cost: Numbers


class ReadOptions(TypedDict, total=False):
    """Of :func:`read_records`."""

    time_column: Any
    time_format: Any
    number_unit: Any
    time_zone: Any
    begin: Any
    end: Any
    separate_files: bool
    separator: Literal['recognise', 'comma', 'semicolon', 'tab']
    decimal: Literal['recognise', 'point', 'comma']
    lines_above_header: Numbers
    rows_below_header: Numbers
    header: Any
    tag_column: Any
    value_column: Any
    quality_column: Any
    empty_fields: Literal['recognise', 'bad', 'unchanged']
    tags: Any
    tag_file: Any
    ignore_other_columns: bool
    quality_suffixes: Any
    good_qualities: Any
    bad_values: Any
    any_word_is_bad: bool
    skip_repeated_times: bool
    spread_repeated_times: bool
    skip_backward_times: bool
    sample_time: Numbers
    max_gap: Numbers
    query: Any
    table: Any
    columns: Any


class CorrectOptions(ReadOptions, total=False):
    """Of :func:`correct`."""

    outputs: Any
    previous: Any
    threads: Numbers
    mark_outliers: bool
    mark_frozen: bool
    window_before: Numbers
    window_after: Numbers
    min_setpoint_change: Numbers
    mode_tag: Any
    change_times: Any
    leave_out: Any
    most_samples: Numbers
    most_samples_in_memory: Numbers
    estimator: Literal['output_error', 'arx']
    false_alarm_probability: Numbers
    confidence: Numbers
    drift: bool
    max_time_constant_factor: Numbers
    max_delay: Numbers
    robust: Literal['none', 'huber', 'cauchy']
    order: Numbers
    conversion_penalty: Numbers
    conversion_samples: Numbers
    seed: Numbers
    selection: Literal['blocks', 'leave_change_out', 'aic', 'bic', 'gcv']
    selection_response_deviations: Numbers
    solver: Literal['homotopy', 'coordinate_descent', 'ceres']
    validation_folds: Numbers
    fewest_changes: Numbers
    prediction_samples: Numbers
    least_change: Numbers
    clock_error: Numbers
    deviations: Numbers
    response_horizon: Numbers
    filter: bool
    control_period: Numbers
    prediction_horizon: Numbers
    control_horizon: Numbers
    output_weight: Numbers
    move_weight: Numbers
    disturbance_variance_ratio: Numbers
    plan: bool
    plan_error: Numbers
    plan_longest: Any
    plan_quiet: Numbers
    plan_set_points: Any
    plan_min_output: Any
    plan_max_output: Any
    plan_min_input: Any
    plan_max_input: Any
    plan_price_squared: Any
    plan_price_absolute: Any


class SimulateOptions(MpcOptions, total=False):
    """Of :func:`simulate`."""

    operating_inputs: Any
    ageing: Any
    age: Numbers
    setpoints: Any
    duration: Numbers
    sample_time: Numbers
    noise_variance: Numbers
    seed: Numbers
    effects: Any
    feed_forward: bool
    preview: bool
    coloured_variance: Numbers
    coloured_time_constant: Numbers
    drift_variance: Numbers
    disturbance_step_rate: Numbers
    disturbance_step_deviation: Numbers
    disturbances: Any
    disturbance_variance: Numbers
    disturbance_time_constant: Numbers
    valve_min: Any
    valve_max: Any
    outlier_probability: Numbers
    outlier_size: Numbers
    quantum: Numbers
    freeze_rate: Numbers
    freeze_duration: Numbers
    lost_probability: Numbers
    lost_input_probability: Numbers
    faults_only_in_record: bool


class LifecycleOptions(TypedDict, total=False):
    """Of :func:`lifecycle`."""

    ageing_rates: Numbers
    years: Numbers
    change_every: Any
    setpoint_range: Numbers
    policies: Any
    seeds: Numbers
    first_seed: Numbers
    figures: bool
    threads: Numbers
    sample_time: Numbers
    noise_variance: Numbers
    disturbance_deviation: Numbers
    disturbance_time: Any
    min_input: Any
    max_input: Any
    min_output: Any
    max_output: Any
    control_period: Numbers
    prediction_horizon: Numbers
    control_horizon: Numbers
    output_weight: Numbers
    move_weight: Numbers
    disturbance_variance_ratio: Numbers
    output_limit_cost: Numbers
    window: Numbers
    quiet_stretch: Numbers
    warm_up: Numbers
    every_sample: bool
    windows: Numbers
    window_age: Any
    calibrate_test: bool
    watch_limit: Numbers
    response_horizon: Numbers
    false_alarm_probability: Numbers
    robust: Literal['none', 'huber', 'cauchy']
    order: Numbers
    conversion_samples: Numbers
    solver: Literal['homotopy', 'coordinate_descent', 'ceres']
    validation_folds: Numbers
    least_change: Numbers
    clock_error: Numbers
    deviations: Numbers
    test_hold: Numbers
    test_cycles: Numbers
    test_move: Any
    price_squared_error: Numbers
    price_absolute_error: Numbers
    price_violation: Numbers
    price_movement: Numbers
    price_test_hour: Numbers
    price_engineer_hour: Numbers
    hours_per_update: Numbers
    hours_per_test: Numbers
    currency: Any
