#include "mle/maintain/element_responses.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kOnEachSide = 1000;
constexpr int kMostPartSamples = 8000;
constexpr int kLeastPartSamples = 50;

using Row = Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>;

// Straight lines, or held values, between good samples; the nearest one at the
// ends; zero without any.
void FillGaps(bool hold, Row row) {
  const Eigen::Index n = row.size();
  Eigen::Index last = -1;
  for (Eigen::Index next = 0; next <= n; ++next) {
    if (next < n && !std::isfinite(row(next))) continue;
    for (Eigen::Index k = last + 1; k < next; ++k) {
      if (last < 0) {
        row(k) = next < n ? row(next) : 0.0;
      } else if (next == n || hold) {
        row(k) = row(last);
      } else {
        row(k) = row(last) + (row(next) - row(last)) *
                                 static_cast<double>(k - last) /
                                 static_cast<double>(next - last);
      }
    }
    last = next;
  }
}

Record Part(const Record& record, int first, int samples) {
  Record part;
  part.start_time = record.time(first);
  part.sample_time = record.sample_time;
  part.outputs = record.outputs.middleCols(first, samples);
  part.inputs = record.inputs.middleCols(first, samples);
  if (record.set_points.size() > 0) {
    part.set_points = record.set_points.middleCols(first, samples);
  }
  for (int i = 0; i < record.num_outputs(); ++i) {
    FillGaps(false, part.outputs.row(i));
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    FillGaps(true, part.inputs.row(j));
  }
  return part;
}

}  // namespace

Record WithoutGaps(const Record& record) {
  return Part(record, 0, record.samples());
}

std::vector<Record> AroundSetPointChanges(const std::vector<Record>& records) {
  std::vector<Record> parts;
  int left = kMostPartSamples;
  for (const Record& record : records) {
    std::vector<std::pair<int, int>> ranges;  // first sample, end
    for (const SetPointChange& change : FindSetPointChanges(record)) {
      const int first = std::max(0, change.sample - kOnEachSide);
      const int end = std::min(record.samples(), change.sample + kOnEachSide);
      if (!ranges.empty() && first <= ranges.back().second) {
        ranges.back().second = end;
      } else {
        ranges.emplace_back(first, end);
      }
    }
    if (record.set_points.size() == 0) ranges = {{0, record.samples()}};
    for (const auto& [first, end] : ranges) {
      const int samples = std::min(end - first, left);
      if (samples < kLeastPartSamples) continue;
      parts.push_back(Part(record, first, samples));
      left -= samples;
    }
  }
  return parts;
}

Assignment Assignment::AsRecorded(const ProcessModel& model) {
  Assignment assignment;
  assignment.outputs.resize(model.num_outputs());
  assignment.inputs.resize(model.num_inputs());
  std::iota(assignment.outputs.begin(), assignment.outputs.end(), 0);
  std::iota(assignment.inputs.begin(), assignment.inputs.end(), 0);
  return assignment;
}

absl::StatusOr<ElementResponses> ElementResponses::Create(
    const ProcessModel& model, const std::vector<Record>& parts,
    double time_scale, Inputs inputs) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  ElementResponses responses;
  responses.parts_ = &parts;
  responses.num_inputs_ = m;
  responses.integrating_ = IntegratingOutputs(model);
  responses.responses_.resize(parts.size());
  for (int k = 0; k < m; ++k) {
    std::vector<int>& columns =
        responses.columns_.emplace_back(static_cast<std::size_t>(p * m), -1);
    std::vector<OutputChannel> driven;
    for (int e = 0; e < p * m; ++e) {
      if (model.element(e / m, e % m).IsZero()) continue;
      if (inputs == Inputs::kOwn && e % m != k) continue;
      columns[e] = static_cast<int>(driven.size());
      driven.push_back({absl::StrCat("element ", e), ""});
    }
    ProcessModel all("elements", model.time_unit(), {{"input", ""}}, driven);
    for (int e = 0; e < p * m; ++e) {
      if (columns[e] < 0) continue;
      all.element(columns[e], 0) = model.element(e / m, e % m);
    }
    for (std::size_t w = 0; w < parts.size(); ++w) {
      Eigen::MatrixXd& of_input = responses.responses_[w].emplace_back();
      if (driven.empty()) continue;
      MLE_ASSIGN_OR_RETURN(
          const Eigen::MatrixXd outputs,
          SimulateResponse(all, parts[w].sample_time / time_scale,
                           parts[w].inputs.row(k)));
      of_input = outputs.transpose();
    }
  }
  return responses;
}

WhitenedData ElementResponses::Row(const Assignment& assignment,
                                   int output) const {
  WhitenedData data;
  for (std::size_t w = 0; w < parts_->size(); ++w) {
    const Record& part = (*parts_)[w];
    data.outputs.emplace_back(
        part.outputs.row(assignment.outputs[output]).transpose());
    Eigen::MatrixXd& row =
        data.responses.emplace_back(part.samples(), num_inputs_);
    for (int j = 0; j < num_inputs_; ++j) {
      const int input = assignment.inputs[j];
      const int column = columns_[input][output * num_inputs_ + j];
      if (column < 0) {
        row.col(j).setZero();
      } else {
        row.col(j) = responses_[w][input].col(column);
      }
    }
  }
  return integrating_[output] ? Increments(data) : data;
}

}  // namespace mle
