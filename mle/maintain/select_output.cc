#include "mle/maintain/select_output.h"

namespace mle {

ProcessModel SelectOutput(const ProcessModel& model, int output) {
  ProcessModel row(model.name(), model.time_unit(), model.inputs(),
                   {model.outputs()[output]});
  for (int j = 0; j < model.num_inputs(); ++j) {
    row.element(0, j) = model.element(output, j);
  }
  return row;
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
