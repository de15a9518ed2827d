"""Twelve mistakes of operators, made in the record or in the model of a plant that has not aged."""

import csv
import json


class Case:
    """A model and a record, to be spoiled."""

    def __init__(self, trial, model, rows):
        self.trial = trial
        self.model = model
        self.header, *lines = rows
        self.columns = {name: [line[i] for line in lines] for i, name in enumerate(self.header)}

    def rows(self):
        return [self.header, *zip(*(self.columns[name] for name in self.header))]

    def scale(self, name, factor, offset=0.0):
        self.columns[name] = [repr(factor * float(value) + offset) if value else value
                              for value in self.columns[name]]

    def scale_output(self, name, factor, offset=0.0):
        """The measurement and its set point."""
        self.scale(name, factor, offset)
        if f"{name}_setpoint" in self.columns:
            self.scale(f"{name}_setpoint", factor, offset)

    def swap(self, first, second):
        columns = self.columns
        columns[first], columns[second] = columns[second], columns[first]

    def two(self, names):
        return self.trial.random.sample(names, 2)

    def scale_times(self, factor):
        for element in self.model["elements"]:
            element["delay"] *= factor
            if "gain" in element:
                element["time_constant"] *= factor
                continue
            for key in ("numerator", "denominator"):
                order = len(element[key]) - 1
                element[key] = [value * factor ** (order - i)
                                for i, value in enumerate(element[key])]

    def scale_gains(self, kind, name, factor):
        for element in self.model["elements"]:
            if element[kind] != name:
                continue
            if "gain" in element:
                element["gain"] *= factor
            else:
                element["numerator"] = [factor * value for value in element["numerator"]]


def swap_outputs(case):
    case.swap(*case.two(case.trial.outputs))


def swap_outputs_and_set_points(case):
    first, second = case.two(case.trial.outputs)
    case.swap(first, second)
    case.swap(f"{first}_setpoint", f"{second}_setpoint")


def swap_inputs(case):
    case.swap(*case.two(case.trial.inputs))


def swap_set_points(case):
    first, second = case.two(case.trial.outputs)
    case.swap(f"{first}_setpoint", f"{second}_setpoint")


def reverse_input(case):
    case.scale(case.trial.any_input(), -1.0)


def reverse_output(case):
    case.scale_output(case.trial.any_output(), -1.0)


def input_per_cent(case):
    case.scale(case.trial.any_input(), 100.0)


def output_thousandth(case):
    case.scale_output(case.trial.any_output(), 1e-3)


def output_fahrenheit(case):
    case.scale_output(case.trial.any_output(), 1.8, 32.0)


def model_row_fahrenheit(case):
    case.scale_gains("output", case.trial.any_output(), 1.8)


def model_column_per_hour(case):
    case.scale_gains("input", case.trial.any_input(), 60.0)


def model_times(case):
    """Seconds for minutes: the model is sixty times as slow, or as fast."""
    case.scale_times(case.trial.random.choice((60.0, 1.0 / 60.0)))


MISTAKES = {
    "outputs exchanged": swap_outputs,
    "outputs exchanged with their set points": swap_outputs_and_set_points,
    "inputs exchanged": swap_inputs,
    "set points exchanged": swap_set_points,
    "sign of an input": reverse_input,
    "sign of an output": reverse_output,
    "input times 100": input_per_cent,
    "output by 1000": output_thousandth,
    "output in °F": output_fahrenheit,
    "model's row in °F": model_row_fahrenheit,
    "model's column by 60": model_column_per_hour,
    "model's times by 60": model_times,
}


def make(name, trial, model_file, record_file):
    """Spoils the files."""
    spoil([MISTAKES[name]], trial, model_file, record_file)


def spoil(changes, trial, model_file, record_file):
    with record_file.open(newline="") as file:
        case = Case(trial, json.loads(model_file.read_text()), list(csv.reader(file)))
    for change in changes:
        change(case)
    model_file.write_text(json.dumps(case.model))
    with record_file.open("w", newline="") as file:
        csv.writer(file).writerows(case.rows())
