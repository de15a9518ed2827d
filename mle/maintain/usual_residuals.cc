#include "mle/maintain/usual_residuals.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::MatrixXd;

// The inputs that move an output.
std::vector<int> InputsOf(const ProcessModel& model) {
  std::vector<int> inputs;
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      if (model.element(i, j).IsZero()) continue;
      inputs.push_back(j);
      break;
    }
  }
  return inputs;
}

// Whether `part` is cut from `record` there: several records may have the same
// times.
bool IsPart(const Record& part, const Record& record, double first) {
  if (!(first >= 0.0) || !(first + part.samples() <= record.samples()) ||
      part.inputs.size() == 0) {
    return false;
  }
  const auto begin = static_cast<Eigen::Index>(first);
  return std::memcmp(part.inputs.data(), record.inputs.col(begin).data(),
                     part.inputs.size() * sizeof(double)) == 0;
}

// Samples of each record that are in a window or in `rest`.
std::vector<std::vector<bool>> UsualSamples(const RecordData& data,
                                            const std::vector<Record>& rest) {
  std::vector<std::vector<bool>> usual;
  for (const Record& record : data.records) {
    usual.emplace_back(record.samples(), false);
  }
  const auto take = [&](std::size_t r, double first, int samples) {
    const double last = first + samples;
    const auto size = static_cast<double>(usual[r].size());
    if (!(first >= 0.0) || !(last <= size)) return;
    std::fill_n(usual[r].begin() + static_cast<std::ptrdiff_t>(first), samples,
                true);
  };
  for (const SetPointWindow& window : data.windows) {
    take(window.source, window.first_sample, window.record.samples());
  }
  for (const Record& part : rest) {
    for (std::size_t r = 0; r < usual.size(); ++r) {
      const Record& record = data.records[r];
      const double first = std::round((part.start_time - record.start_time) /
                                      record.sample_time);
      if (IsPart(part, record, first)) take(r, first, part.samples());
    }
  }
  return usual;
}

}  // namespace

absl::StatusOr<std::vector<MatrixXd>> UsualResiduals(
    const ProcessModel& model, const RecordData& data,
    const std::vector<Record>& rest) {
  MLE_ASSIGN_OR_RETURN(const InputResponse response,
                       ResponseOf(model, data.sample_time()));
  const std::vector<int> inputs = InputsOf(model);
  const std::vector<std::vector<bool>> usual = UsualSamples(data, rest);
  std::vector<MatrixXd> residuals;
  for (std::size_t r = 0; r < data.records.size(); ++r) {
    const Record& record = data.records[r];
    const auto known = [&](int k) {
      return record.inputs(inputs, k).allFinite();
    };
    for (int begin = 0; begin < record.samples(); ++begin) {
      int end = begin;
      while (end < record.samples() && known(end)) ++end;
      if (end - begin > response.forgetting) {
        Record run = PartOf(record, begin, end - begin);
        // What is not known there moves no output.
        run.inputs = run.inputs.array().isFinite().select(run.inputs, 0.0);
        MLE_ASSIGN_OR_RETURN(MatrixXd simulated, response.response(run));
        MatrixXd left = run.outputs - simulated;
        left.leftCols(response.forgetting).setConstant(kNaN);
        for (int k = begin; k < end; ++k) {
          if (!usual[r][k]) left.col(k - begin).setConstant(kNaN);
        }
        residuals.push_back(std::move(left));
      }
      begin = end;
    }
  }
  return residuals;
}

}  // namespace mle
