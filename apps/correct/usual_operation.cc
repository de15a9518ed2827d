#include "apps/correct/usual_operation.h"

#include <algorithm>
#include <cmath>

namespace mle::correct {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Adds squares of `row` about `center`, or about its mean where that is empty.
void AddSquares(const VectorXd& row, const VectorXd& center, ChannelUse& use) {
  double sum = 0.0;
  double count = 0.0;
  for (const double value : row) {
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  if (count < 2.0) return;
  for (Index k = 0; k < row.size(); ++k) {
    const double about = center.size() > 0 ? center(k) : sum / count;
    if (!std::isfinite(row(k)) || !std::isfinite(about)) continue;
    use.squares += (row(k) - about) * (row(k) - about);
    use.count += 1.0;
  }
}

// Adds what is between the changes of set points of a record, once each has
// settled.
void AddResting(const Record& record, int settled, std::vector<Record>& parts) {
  int first = 0;
  const auto add = [&](int end) {
    if (end - first > 1) parts.push_back(PartOf(record, first, end - first));
  };
  for (const SetPointChange& change : FindSetPointChanges(record)) {
    add(change.sample);
    first = std::max(first, change.sample + settled);
  }
  add(record.samples());
}

// Between the windows, while the plant was operated as usual.
const std::vector<Record>& UsualRest(const Result& result) {
  static const std::vector<Record> none;
  const auto& rest = result.options.estimation.output_error.at_rest;
  return rest != nullptr ? *rest : none;
}

// Parts in which nothing is asked of the plant: between the windows, in them
// before their first change, and records in which nothing changes.
std::vector<Record> QuietParts(const Result& result) {
  const RecordData& data = result.data;
  std::vector<Record> parts;
  for (const Record& rest : UsualRest(result)) {
    AddResting(rest, data.lead, parts);
  }
  for (const SetPointWindow& window : data.windows) {
    const int samples = window.changes.empty() ? window.record.samples()
                                               : window.changes.front().sample;
    AddResting(PartOf(window.record, 0, samples), data.lead, parts);
  }
  return parts;
}

}  // namespace

void ChannelUse::AddToRange(double value) {
  if (!std::isfinite(value)) return;
  known = true;
  low = std::min(low, value);
  high = std::max(high, value);
}

double ChannelUse::deviation() const {
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

Operation OperationIn(const Result& result) {
  const int p = result.initial.num_outputs();
  const int m = result.initial.num_inputs();
  Operation operation;
  operation.outputs.resize(p);
  operation.inputs.resize(m);
  operation.set_points.resize(p);
  const auto each = [&](const Record& record, const auto& visit) {
    for (Index k = 0; k < record.samples(); ++k) {
      for (int i = 0; i < p; ++i) {
        visit(record.outputs(i, k), operation.outputs[i]);
        if (record.set_points.size() > 0) {
          visit(record.set_points(i, k), operation.set_points[i]);
        }
      }
      for (int j = 0; j < m; ++j) {
        visit(record.inputs(j, k), operation.inputs[j]);
      }
    }
  };
  const auto add = [](double value, ChannelUse& use) { use.AddToRange(value); };
  for (const SetPointWindow& window : result.data.windows) {
    each(window.record, add);
  }
  for (const Record& rest : UsualRest(result)) each(rest, add);
  for (const Record& record : result.data.records) {
    each(record, [](double value, ChannelUse& use) {
      if (std::isfinite(value)) use.last = value;
    });
  }
  for (const Record& part : QuietParts(result)) {
    for (int i = 0; i < p; ++i) {
      const VectorXd center = part.set_points.size() > 0
                                  ? VectorXd(part.set_points.row(i))
                                  : VectorXd();
      AddSquares(part.outputs.row(i), center, operation.outputs[i]);
    }
    for (int j = 0; j < m; ++j) {
      AddSquares(part.inputs.row(j), {}, operation.inputs[j]);
    }
  }
  return operation;
}

VectorXd Deviations(const std::vector<ChannelUse>& uses) {
  VectorXd deviations(std::ssize(uses));
  for (std::size_t c = 0; c < uses.size(); ++c) {
    deviations(static_cast<Index>(c)) = uses[c].deviation();
  }
  return deviations;
}

}  // namespace mle::correct
