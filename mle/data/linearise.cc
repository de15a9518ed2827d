#include "mle/data/linearise.h"

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::Index;

absl::Status CheckRow(const Eigen::MatrixXd& values, int row,
                      const std::string& name, const Transform& transform,
                      const ProcessModel& model, const Record& record) {
  for (Index k = 0; k < values.cols(); ++k) {
    const double x = values(row, k);
    if (!std::isfinite(x) || std::abs(transform.Linear(x)) <= kLargestSample) {
      continue;
    }
    return InvalidArgument(absl::StrFormat(
        "%s is %.6g at %.6g %s, where its transform (%s) has no value that can "
        "be used; mark such samples as bad, or give it a transform that holds "
        "them",
        name, x, record.time(static_cast<int>(k)), model.time_unit(),
        transform.Description()));
  }
  return absl::OkStatus();
}

template <typename Change>
void ChangeRows(const ProcessModel& model, const Change& change,
                Record& record) {
  const auto change_row = [&](const Transform& transform, int row,
                              Eigen::MatrixXd& values) {
    if (transform.IsNone() || row >= values.rows()) return;
    for (double& x : values.row(row)) x = change(transform, x);
  };
  for (int j = 0; j < model.num_inputs(); ++j) {
    change_row(model.inputs()[j].transform, j, record.inputs);
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    change_row(model.outputs()[i].transform, i, record.outputs);
    change_row(model.outputs()[i].transform, i, record.set_points);
  }
}

}  // namespace

absl::Status Linearise(const ProcessModel& model, Record& record) {
  if (!HasTransforms(model)) return absl::OkStatus();
  for (int j = 0; j < model.num_inputs(); ++j) {
    const InputChannel& input = model.inputs()[j];
    MLE_RETURN_IF_ERROR(
        CheckRow(record.inputs, j, input.name, input.transform, model, record));
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    const OutputChannel& output = model.outputs()[i];
    MLE_RETURN_IF_ERROR(CheckRow(record.outputs, i, output.name,
                                 output.transform, model, record));
    if (record.set_points.rows() == 0) continue;
    MLE_RETURN_IF_ERROR(CheckRow(record.set_points, i,
                                 absl::StrCat("the set point of ", output.name),
                                 output.transform, model, record));
  }
  ChangeRows(
      model, [](const Transform& t, double x) { return t.Linear(x); }, record);
  return absl::OkStatus();
}

void Delinearise(const ProcessModel& model, Record& record) {
  ChangeRows(
      model, [](const Transform& t, double z) { return t.Engineering(z); },
      record);
}

}  // namespace mle
