#include "apps/correct/prospects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Core"
#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"
#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/data/stretches.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/prediction.h"
#include "mle/nonlinear/distributions.h"

namespace mle::correct {
namespace {

// Of records without noise, relative to the output's own variance.
constexpr double kLeastVariance = 1e-12;
constexpr double kByChance = 0.01;

double MeanSquare(const Eigen::RowVectorXd& values) {
  double sum = 0.0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value * value;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

// White noise r and a random walk ρ r whose predictions one sample ahead have
// these errors: Var ε = r (1 + (ρ + √(ρ² + 4ρ)) / 2).
NoiseEstimate NoiseOf(const Eigen::RowVectorXd& errors, double spread,
                      double ratio) {
  const double steady = 0.5 * (ratio + std::sqrt(ratio * (ratio + 4.0)));
  NoiseEstimate noise;
  noise.ratio = ratio;
  noise.variance =
      std::max({MeanSquare(errors) / (1.0 + steady), kLeastVariance * spread,
                std::numeric_limits<double>::min()});
  return noise;
}

// Of each output over all records.
std::vector<NoiseEstimate> NoiseOfPredictions(
    const std::vector<Record>& records, const Predictor& predictor,
    const Eigen::VectorXd& ratios) {
  const Record joined = JoinRecords(records);
  Eigen::MatrixXd errors(joined.num_outputs(), joined.samples());
  int first = 0;
  for (const Record& record : records) {
    errors.middleCols(first, record.samples()) = predictor(record, 1);
    first += record.samples();
  }
  std::vector<NoiseEstimate> noise;
  for (int i = 0; i < joined.num_outputs(); ++i) {
    const double spread = RobustDeviation(joined.outputs.row(i));
    noise.push_back(NoiseOf(errors.row(i), spread * spread, ratios(i)));
  }
  return noise;
}

// Where nothing is asked of the plant an aged model has no errors of its own:
// what lies outside of the windows, if that is a settling time and more.
std::vector<Record> RecordsOfNoise(const RecordData& data,
                                   const std::vector<Record>& windows) {
  constexpr int kFewest = 200;
  std::vector<Record> rest;
  int samples = 0;
  for (Record& record : data.AtRest()) {
    if (record.samples() <= data.lead / 2) continue;
    samples += record.samples();
    rest.push_back(std::move(record));
  }
  return samples >= std::max(kFewest, data.lead) ? rest : windows;
}

// Means over blocks of `samples`, a column each; NaN where one is missing.
Eigen::MatrixXd BlockMeans(const Eigen::MatrixXd& values, int samples) {
  Eigen::MatrixXd means(values.rows(), values.cols() / samples);
  for (Eigen::Index b = 0; b < means.cols(); ++b) {
    means.col(b) = values.middleCols(b * samples, samples).rowwise().mean();
  }
  return means;
}

constexpr int kInputLags = 6;
constexpr int kErrorLags = 4;

// Rows (1, lags of all inputs, lags of the errors, the inputs) for the blocks
// of which all is known, added to those of other windows.
void AddRows(const Eigen::MatrixXd& inputs, const Eigen::RowVectorXd& errors,
             Eigen::MatrixXd& rows) {
  const Eigen::Index m = inputs.rows();
  for (Eigen::Index k = kInputLags; k < inputs.cols(); ++k) {
    Eigen::RowVectorXd row(1 + kInputLags * m + kErrorLags + m);
    row(0) = 1.0;
    for (int l = 1; l <= kInputLags; ++l) {
      row.segment(1 + (l - 1) * m, m) = inputs.col(k - l).transpose();
    }
    row.segment(1 + kInputLags * m, kErrorLags) =
        errors.segment(k - kErrorLags, kErrorLags);
    row.tail(m) = inputs.col(k).transpose();
    if (!row.allFinite()) continue;
    rows.conservativeResize(rows.rows() + 1, row.size());
    rows.bottomRows(1) = row;
  }
}

// What `columns` leave of each of `values`.
Eigen::MatrixXd LeftOf(const Eigen::MatrixXd& columns,
                       const Eigen::MatrixXd& values) {
  return values - columns * columns.colPivHouseholderQr().solve(values);
}

// `values` of which the columns leave no more than four robust deviations: the
// moves by which set points are followed would hide all others.
Eigen::MatrixXd Winsorised(const Eigen::MatrixXd& columns,
                           Eigen::MatrixXd values) {
  constexpr double kLargest = 4.0;
  constexpr int kFits = 5;
  for (int fit = 0; fit < kFits; ++fit) {
    const Eigen::MatrixXd left = LeftOf(columns, values);
    for (Eigen::Index j = 0; j < left.cols(); ++j) {
      const double limit =
          kLargest * RobustDeviation(left.col(j).transpose().eval());
      values.col(j) +=
          left.col(j).cwiseMax(-limit).cwiseMin(limit) - left.col(j);
    }
  }
  return values;
}

// Granger's test: whether the errors of a simulation help to predict an input
// from its own past (Econometrica 37, 1969).
bool HasFeedback(const Eigen::MatrixXd& rows, Eigen::Index m) {
  const Eigen::Index columns = rows.cols() - m;
  const auto left = static_cast<double>(rows.rows() - columns);
  if (left < static_cast<double>(columns)) return false;
  const Eigen::MatrixXd own = rows.leftCols(columns - kErrorLags);
  const Eigen::MatrixXd inputs = Winsorised(own, rows.rightCols(m));
  const Eigen::MatrixXd without = LeftOf(own, inputs);
  const Eigen::MatrixXd with = LeftOf(rows.leftCols(columns), inputs);
  for (Eigen::Index j = 0; j < m; ++j) {
    const double rest = with.col(j).squaredNorm();
    const double F =
        (without.col(j).squaredNorm() - rest) / kErrorLags / (rest / left);
    if (FisherTail(F, kErrorLags, left) < kByChance / static_cast<double>(m)) {
      return true;
    }
  }
  return false;
}

// p: whether some input answers to the output.
std::vector<bool> FindFeedback(const std::vector<Record>& windows,
                               const Predictor& predictor, int order) {
  constexpr int kBlocksOfMemory = 10;
  const int samples = std::max(1, order / kBlocksOfMemory);
  const Eigen::Index m = windows.front().num_inputs();
  std::vector<Eigen::MatrixXd> rows(windows.front().num_outputs());
  for (const Record& window : windows) {
    const Eigen::MatrixXd inputs = BlockMeans(window.inputs, samples);
    const Eigen::MatrixXd errors = BlockMeans(predictor(window, 0), samples);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      AddRows(inputs, errors.row(static_cast<Eigen::Index>(i)), rows[i]);
    }
  }
  std::vector<bool> feedback;
  for (const Eigen::MatrixXd& one : rows) {
    feedback.push_back(HasFeedback(one, m));
  }
  return feedback;
}

std::string PercentOf(double share) {
  return std::isfinite(share) ? report::FormatSignificant(100.0 * share, 2)
                              : "–";
}

const char* InWords(PairState state) {
  switch (state) {
    case PairState::kAbsent:
      return "not in the model";
    case PairState::kNotInformed:
      return "not informed";
    case PairState::kWeak:
      return "weak";
    case PairState::kInformed:
      return "informed";
  }
  return "";
}

std::string DescribeFeedback(const Prospects& prospects,
                             const ProcessModel& model) {
  std::vector<std::string> outputs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (prospects.feedback[i]) outputs.push_back(model.outputs()[i].name);
  }
  if (outputs.empty()) {
    return "No input was seen to answer to an output, as in open loop.\n";
  }
  return absl::StrCat("Inputs answer to ", absl::StrJoin(outputs, ", "),
                      ": a controller is on.\n");
}

}  // namespace

absl::StatusOr<Prospects> FindProspects(const RecordData& data,
                                        const ProcessModel& model,
                                        int threads) {
  if (!data.obstacles.empty()) {
    return absl::FailedPreconditionError(Shown(data.obstacles.front()));
  }
  const std::vector<Record> windows = JoinAdjoining(data.Records()).records;
  MLE_ASSIGN_OR_RETURN(const InputResponse response,
                       ResponseOf(model, data.sample_time()));
  const std::vector<Record> quiet = RecordsOfNoise(data, windows);
  MLE_ASSIGN_OR_RETURN(const Eigen::VectorXd ratios,
                       FitLevelRatios(response, quiet));
  const Predictor predictor = PredictWithLevel(response, ratios);
  Prospects prospects;
  MLE_ASSIGN_OR_RETURN(
      prospects.information,
      AssessInformation(model, windows,
                        NoiseOfPredictions(quiet, predictor, ratios),
                        {.output_error = {.threads = threads}}));
  prospects.feedback =
      FindFeedback(windows, predictor,
                   ConversionSettings().OrderFor(model, data.sample_time()));
  return prospects;
}

report::Table ProspectTable(const Prospects& prospects,
                            const ProcessModel& model) {
  report::Table table{
      .caption = "Standard errors that a correction may expect",
      .columns = {{"element", report::Align::kLeft},
                  {"gain (%)"},
                  {"time constant (%)"},
                  {absl::StrCat("dead time (", model.time_unit(), ")")},
                  {"records", report::Align::kLeft}}};
  for (const auto& [i, j] : Pairs(model)) {
    const PairErrors& pair = prospects.information.pair(i, j);
    if (pair.state == PairState::kAbsent) continue;
    table.AddRow({PairName(model, i, j), PercentOf(pair.gain),
                  PercentOf(pair.time_scale),
                  std::isfinite(pair.delay)
                      ? report::FormatSignificant(pair.delay, 2)
                      : "–",
                  InWords(pair.state)});
  }
  return table;
}

std::string DescribeRecords(const RecordData& data,
                            const std::vector<DataFile>& files,
                            const ProcessModel& model,
                            const absl::StatusOr<Prospects>& prospects) {
  std::string text =
      absl::StrCat(report::RenderText(FileTable(data, files, model)), "\n",
                   report::RenderText(ChannelTable(data, model)), "\n",
                   report::RenderText(WindowTable(data, model)), "\n");
  if (prospects.ok()) {
    absl::StrAppend(&text, report::RenderText(ProspectTable(*prospects, model)),
                    "\n", DescribeFeedback(*prospects, model));
  } else {
    absl::StrAppend(&text, "Nothing could be corrected from these records: ",
                    std::string(prospects.status().message()), "\n");
  }
  for (const Message& note : data.notes) {
    absl::StrAppend(&text, Shown(note), "\n");
  }
  return text;
}

}  // namespace mle::correct
