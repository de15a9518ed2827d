#include "apps/correct/prospects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/data/segments.h"
#include "mle/explain/feedback.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/prediction.h"

namespace mle::correct {
namespace {

// Of records without noise, relative to the output's own variance.
constexpr double kLeastVariance = 1e-12;

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

std::string PercentOf(double share) {
  return std::isfinite(share) ? report::FormatSignificant(100.0 * share, 2)
                              : "–";
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
  std::vector<std::optional<double>> p_values(
      static_cast<std::size_t>(model.num_outputs()));
  ParallelFor(model.num_outputs(), threads, [&](int i) {
    p_values[static_cast<std::size_t>(i)] = FeedbackPValue(model, windows, i);
  });
  for (const std::optional<double>& p_value : p_values) {
    prospects.feedback.push_back(p_value.has_value() && *p_value < kFeedback);
  }
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
    table.AddRow(
        {PairName(model, i, j), PercentOf(pair.gain),
         PercentOf(pair.time_scale),
         std::isfinite(pair.delay) ? report::FormatSignificant(pair.delay, 2)
                                   : "–",
         absl::StrReplaceAll(std::string(NameOf(pair.state)), {{"_", " "}})});
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
