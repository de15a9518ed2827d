"""Figures by matplotlib, which is imported when the first is drawn."""

from __future__ import annotations

from typing import Any, Tuple


def _panels(axes: Any, rows: int, columns: int, share: str) -> Tuple[Any, Any]:
    """(figure, axes as a table) of those given, or new ones."""
    import numpy as np

    if axes is None:
        try:
            from matplotlib import pyplot
        except ImportError as error:
            raise ImportError("figures need matplotlib: pip install matplotlib") from error
        _, axes = pyplot.subplots(
            rows,
            columns,
            figsize=(max(4.0 * columns, 7.0), max(2.4 * rows, 3.0)),
            squeeze=False,
            sharex=share,
            layout="constrained",
        )
    axes = np.reshape(axes, (rows, columns))
    return axes[0, 0].figure, axes


def _with_unit(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def draw_responses(result: Any, axes: Any) -> Any:
    """The step responses before and after a correction, with the band of the latter."""
    model, response = result.initial, result.step_response
    changed = result.elements.aged
    figure, axes = _panels(axes, len(model.outputs), len(model.inputs), "all")
    for i, output in enumerate(model.outputs):
        for j, name in enumerate(model.inputs):
            axis = axes[i, j]
            axis.plot(response.time, response.initial[:, i, j], "C7--", label="controller's model")
            if result.decision == "corrected":
                axis.plot(response.time, response.corrected[:, i, j], "C0", label="corrected")
                if response.lower is not None:
                    band = (response.lower[:, i, j], response.upper[:, i, j])
                    axis.fill_between(response.time, *band, color="C0", alpha=0.2, lw=0)
            mark = ", changed" if changed.get((output, name), False) else ""
            axis.set_title(f"{output} ← {name}{mark}", fontsize="medium")
        axes[i, 0].set_ylabel(_with_unit(output, model.output_units[i]))
    for axis in axes[-1]:
        axis.set_xlabel(f"time ({model.time_unit})")
    axes[0, 0].legend(fontsize="small")
    return figure


def draw_comparison(comparison: Any, axes: Any) -> Any:
    """Outputs, measured and predicted."""
    outputs = list(comparison.fits.index)
    figure, axes = _panels(axes, len(outputs), 1, "all")
    for axis, output in zip(axes[:, 0], outputs):
        for k, measured in enumerate(comparison.measured):
            axis.plot(measured[output], ".", color="C7", ms=2, label="measured" if k == 0 else None)
            for line, (name, frames) in enumerate(comparison.predicted.items()):
                fit = comparison.fits.loc[output, name]
                label = f"{name}: {fit:.1f} %" if k == 0 else None
                axis.plot(frames[k][output], color=f"C{line}", lw=1, label=label)
        axis.set_ylabel(output)
        axis.legend(fontsize="small", loc="upper right")
    if comparison.measured[0].index.dtype.kind == "M":
        from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

        locator = AutoDateLocator()
        axes[-1, 0].xaxis.set_major_locator(locator)
        axes[-1, 0].xaxis.set_major_formatter(ConciseDateFormatter(locator))
    axes[-1, 0].set_xlabel("time")
    return figure


def draw_residuals(residuals: Any, axes: Any) -> Any:
    """Correlations of residuals over the lag, within their limits if they are white."""
    outputs = list(residuals.autocorrelation.columns)
    inputs = list(residuals.p_values.columns[1:])
    figure, axes = _panels(axes, len(outputs), 1 + len(inputs), "col")
    for i, output in enumerate(outputs):
        limit = residuals.autocorrelation_limits[output]
        parts = [(residuals.autocorrelation[output], limit, "itself")]
        parts += [
            (
                residuals.cross_correlation[(output, name)],
                residuals.cross_correlation_limits[(output, name)],
                name,
            )
            for name in inputs
        ]
        for axis, (values, limit, name) in zip(axes[i], parts):
            axis.vlines(values.index, 0.0, values, lw=1)
            axis.axhspan(-limit, limit, color="C7", alpha=0.3, lw=0)
            axis.set_title(f"{output} with {name}", fontsize="medium")
    for axis in axes[-1]:
        axis.set_xlabel("lag (samples)")
    return figure
