#include "mle/maintain/element_responses.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kOnEachSide = 1000;
constexpr double kMostPartSamples = 8000.0;
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

Record WholePart(const Record& record, int first, int samples) {
  Record part = PartOf(record, first, samples);
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
  return WholePart(record, 0, record.samples());
}

std::vector<Record> AroundSetPointChanges(const std::vector<Record>& records,
                                          double most_samples) {
  std::vector<Record> parts;
  int left = static_cast<int>(std::min(kMostPartSamples, most_samples));
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
      parts.push_back(WholePart(record, first, samples));
      left -= samples;
    }
  }
  return parts;
}

absl::StatusOr<ElementResponses> ElementResponses::Create(
    const ProcessModel& model, const std::vector<Record>& parts,
    double time_scale) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  ElementResponses responses;
  responses.parts_ = &parts;
  responses.time_scale_ = time_scale;
  responses.num_inputs_ = m;
  responses.integrating_ = IntegratingOutputs(model);
  responses.columns_.assign(static_cast<std::size_t>(p) * m, -1);
  for (int j = 0; j < m; ++j) {
    std::vector<OutputChannel> driven;
    std::vector<TransferFunction> elements;
    for (int i = 0; i < p; ++i) {
      if (model.element(i, j).IsZero()) continue;
      responses.columns_[i * m + j] = static_cast<int>(driven.size());
      driven.push_back({absl::StrCat("output ", i), ""});
      elements.push_back(model.element(i, j));
    }
    ProcessModel& of_input = responses.of_input_.emplace_back(
        "elements", model.time_unit(), std::vector<InputChannel>{{"input", ""}},
        driven);
    for (std::size_t e = 0; e < elements.size(); ++e) {
      of_input.element(static_cast<int>(e), 0) = elements[e];
    }
    MLE_ASSIGN_OR_RETURN(responses.responses_.emplace_back(),
                         responses.Of(j, j));
  }
  return responses;
}

absl::StatusOr<ElementResponses::OfInput> ElementResponses::Of(
    int input, int recorded) const {
  OfInput responses;
  const ProcessModel& elements = of_input_[input];
  for (const Record& part : *parts_) {
    Eigen::MatrixXd& of_part = responses.emplace_back(part.samples(), 0);
    if (elements.num_outputs() == 0) continue;
    MLE_ASSIGN_OR_RETURN(
        const Eigen::MatrixXd outputs,
        SimulateResponse(elements, part.sample_time / time_scale_,
                         part.inputs.row(recorded)));
    of_part = outputs.transpose();
  }
  return responses;
}

WhitenedData ElementResponses::Row(int output) const {
  WhitenedData data;
  for (std::size_t w = 0; w < parts_->size(); ++w) {
    const Record& part = (*parts_)[w];
    data.outputs.emplace_back(part.outputs.row(output).transpose());
    Eigen::MatrixXd& row =
        data.responses.emplace_back(part.samples(), num_inputs_);
    for (int j = 0; j < num_inputs_; ++j) {
      const int column = ColumnOf(output, j);
      if (column < 0) {
        row.col(j).setZero();
      } else {
        row.col(j) = responses_[j][w].col(column);
      }
    }
  }
  return integrating_[output] ? Increments(data) : data;
}

}  // namespace mle
