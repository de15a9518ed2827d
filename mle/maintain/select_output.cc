#include "mle/maintain/select_output.h"

#include <numeric>
#include <utility>

namespace mle {

ProcessModel SelectPart(const ProcessModel& model,
                        const std::vector<int>& outputs,
                        const std::vector<int>& inputs) {
  std::vector<InputChannel> of_inputs;
  std::vector<OutputChannel> of_outputs;
  for (const int j : inputs) of_inputs.push_back(model.inputs()[j]);
  for (const int i : outputs) of_outputs.push_back(model.outputs()[i]);
  ProcessModel part(model.name(), model.time_unit(), std::move(of_inputs),
                    std::move(of_outputs));
  for (int i = 0; i < part.num_outputs(); ++i) {
    for (int j = 0; j < part.num_inputs(); ++j) {
      part.element(i, j) = model.element(outputs[i], inputs[j]);
    }
  }
  return part;
}

ProcessModel SelectPart(const ProcessModel& model,
                        const std::vector<int>& outputs) {
  std::vector<int> inputs(static_cast<std::size_t>(model.num_inputs()));
  std::iota(inputs.begin(), inputs.end(), 0);
  return SelectPart(model, outputs, inputs);
}

ProcessModel SelectOutput(const ProcessModel& model, int output) {
  return SelectPart(model, std::vector<int>{output});
}

Record SelectOutput(const Record& record, int output) {
  Record selected;
  selected.start_time = record.start_time;
  selected.sample_time = record.sample_time;
  selected.inputs = record.inputs;
  selected.outputs = record.outputs.row(output);
  if (record.set_points.size() > 0) {
    selected.set_points = record.set_points.row(output);
  }
  return selected;
}

}  // namespace mle
