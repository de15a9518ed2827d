#include "mle/exchange/step_response_text.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/element_columns.h"
#include "mle/model/channels_json.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

absl::StatusOr<bool> ReadIsRamp(const JsonNode& node) {
  if (!node.Has("end")) return false;
  MLE_ASSIGN_OR_RETURN(const std::string end, node.At("end").String());
  if (end == "steady" || end == "ramp") return end == "ramp";
  return node.At("end").Fault("is ", QuotedJson(end),
                              ", must be \"steady\" or \"ramp\"");
}

// One entry of step_responses; the first says how many coefficients there are.
absl::Status ReadPair(const JsonNode& node, StepResponseModel& model) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"output", "input", "coefficients"}, {"end"}));
  PairResponse pair;
  MLE_ASSIGN_OR_RETURN(pair.output, FindOutput(node, model.channels));
  MLE_ASSIGN_OR_RETURN(pair.input, FindInput(node, model.channels));
  for (const PairResponse& other : model.pairs) {
    if (other.output != pair.output || other.input != pair.input) continue;
    return node.Fault("the pair ",
                      PairName(model.channels, pair.output, pair.input),
                      " is duplicated; give each pair once");
  }
  MLE_ASSIGN_OR_RETURN(pair.is_ramp, ReadIsRamp(node));
  MLE_ASSIGN_OR_RETURN(const std::vector<double> numbers,
                       node.At("coefficients").Numbers());
  const auto length = static_cast<int>(numbers.size());
  if (!model.pairs.empty() && length != model.length()) {
    return node.At("coefficients")
        .Fault("has ", length, " coefficients, the first pair has ",
               model.length(), "; all must have as many");
  }
  pair.coefficients = Eigen::Map<const Eigen::VectorXd>(numbers.data(), length);
  model.pairs.push_back(std::move(pair));
  return absl::OkStatus();
}

absl::Status CheckSteadyState(const JsonNode& top,
                              const StepResponseModel& model) {
  if (!top.Has("time_to_steady_state")) return absl::OkStatus();
  const JsonNode node = top.At("time_to_steady_state");
  MLE_ASSIGN_OR_RETURN(const double stated, node.Number(kPositive));
  return node.Check(model.CheckSteadyState(stated));
}

using Pair = std::pair<int, int>;            // output, input
using Labels = std::map<std::string, Pair>;  // by "<output>/<input>"

std::string Label(const ProcessModel& channels, int output, int input) {
  return absl::StrCat(channels.outputs()[output].name, "/",
                      channels.inputs()[input].name);
}

// The pairs that the header names, where the head names no channel.
absl::StatusOr<std::vector<ModelTable::PairOfNames>> NamesInHeader(
    const ModelTable& table) {
  std::vector<ModelTable::PairOfNames> pairs;
  for (std::size_t c = 1; c < table.header.fields.size(); ++c) {
    const std::string& field = table.header.fields[c];
    const std::size_t slash = field.find('/');
    const bool one = slash != std::string::npos &&
                     field.find('/', slash + 1) == std::string::npos;
    if (!one || slash == 0 || slash + 1 == field.size()) {
      return table.Fault(
          table.header, static_cast<int>(c),
          absl::StrCat("'", ShowCsvText(field),
                       "' is not a pair, written output/input; names with a "
                       "slash need lines 'input,…' and 'output,…' above the "
                       "table"));
    }
    pairs.push_back({field.substr(0, slash), field.substr(slash + 1)});
  }
  return pairs;
}

absl::StatusOr<Labels> LabelsOf(const ModelTable& table,
                                const ProcessModel& channels) {
  Labels labels;
  for (const auto& [i, j] : Pairs(channels)) {
    const std::string label = Label(channels, i, j);
    if (labels.emplace(label, Pair(i, j)).second) continue;
    return table.Fault(table.header.line,
                       absl::StrCat("'", ShowCsvText(label),
                                    "' may be two pairs: rename a channel"));
  }
  return labels;
}

absl::StatusOr<Pair> FindPair(const ModelTable& table, const TableLine& line,
                              int column, const Labels& labels) {
  const std::string& field = line.fields[column];
  if (const auto found = labels.find(field); found != labels.end()) {
    return found->second;
  }
  return table.Fault(
      line, column,
      absl::StrCat(
          "'", ShowCsvText(field),
          "' is not a pair of the model; the pairs are ",
          absl::StrJoin(labels, ", ", [](std::string* out, const auto& label) {
            absl::StrAppend(out, label.first);
          })));
}

// A pair for each column but the first.
absl::Status ReadPairColumns(const ModelTable& table, const Labels& labels,
                             StepResponseModel& model) {
  for (std::size_t c = 1; c < table.header.fields.size(); ++c) {
    const auto column = static_cast<int>(c);
    MLE_ASSIGN_OR_RETURN(const Pair pair,
                         FindPair(table, table.header, column, labels));
    for (std::size_t before = 0; before < model.pairs.size(); ++before) {
      const PairResponse& other = model.pairs[before];
      if (Pair(other.output, other.input) != pair) continue;
      return table.Fault(
          table.header, column,
          absl::StrCat("the pair '", ShowCsvText(table.header.fields[c]),
                       "' stands in column ", before + 2,
                       " already; give each pair once"));
    }
    model.pairs.push_back({pair.first, pair.second, {}, false});
  }
  if (!model.pairs.empty()) return absl::OkStatus();
  return table.Fault(table.header.line,
                     "no pair, written output/input, follows 'time'");
}

absl::StatusOr<double> ReadInterval(const ModelTable& table) {
  for (const TableLine& line : table.others) {
    if (line.fields.front() != "interval") continue;
    MLE_ASSIGN_OR_RETURN(const double interval, table.Number(line, 1));
    if (interval > 0.0) return interval;
    return table.Fault(
        line, 1,
        absl::StrCat("the interval is ", interval, ", must be positive"));
  }
  return table.Fault(table.header.line,
                     "the table begins, but no line above it has the interval "
                     "of the coefficients, such as 'interval,1'");
}

absl::Status CheckTime(const ModelTable& table, const TableLine& row,
                       double wanted, double interval) {
  MLE_ASSIGN_OR_RETURN(const double time, table.Number(row, 0));
  if (std::abs(time - wanted) <= kTimeTolerance * interval) {
    return absl::OkStatus();
  }
  return table.Fault(row, 0,
                     absl::StrCat("the time is ", time, ", must be ", wanted,
                                  " with an interval of ", interval,
                                  "; the first time is 0 or one interval"));
}

absl::Status ReadCoefficients(const ModelTable& table,
                              StepResponseModel& model) {
  MLE_ASSIGN_OR_RETURN(const double first, table.Number(table.rows[0], 0));
  // A row of time 0 may stand first; it has zeros.
  const int before = std::abs(first) < 0.5 * model.interval ? 1 : 0;
  const auto rows = static_cast<int>(table.rows.size());
  for (PairResponse& pair : model.pairs)
    pair.coefficients.resize(rows - before);
  for (int r = 0; r < rows; ++r) {
    const TableLine& row = table.rows[r];
    MLE_RETURN_IF_ERROR(CheckTime(table, row, (r + 1 - before) * model.interval,
                                  model.interval));
    for (std::size_t c = 0; c < model.pairs.size(); ++c) {
      const auto column = static_cast<int>(c) + 1;
      MLE_ASSIGN_OR_RETURN(const double value, table.Number(row, column));
      if (r >= before) {
        model.pairs[c].coefficients(r - before) = value;
      } else if (value != 0.0) {
        return table.Fault(
            row, column,
            absl::StrCat("the response at time 0 is ", value, ", must be 0"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status ReadRamps(const ModelTable& table, const TableLine& line,
                       const Labels& labels, StepResponseModel& model) {
  for (std::size_t c = 1; c < line.fields.size(); ++c) {
    const auto column = static_cast<int>(c);
    MLE_ASSIGN_OR_RETURN(const Pair pair,
                         FindPair(table, line, column, labels));
    const auto found = std::find_if(
        model.pairs.begin(), model.pairs.end(), [&](const PairResponse& one) {
          return Pair(one.output, one.input) == pair;
        });
    if (found == model.pairs.end()) {
      return table.Fault(line, column, "the table has no column of this pair");
    }
    found->is_ramp = true;
  }
  return absl::OkStatus();
}

absl::Status CheckSteadyStateLine(const ModelTable& table,
                                  const TableLine& line,
                                  const StepResponseModel& model) {
  MLE_ASSIGN_OR_RETURN(const double stated, table.Number(line, 1));
  const absl::Status status = model.CheckSteadyState(stated);
  if (status.ok()) return status;
  return table.Fault(
      line, 1, absl::StrCat("the time to steady state ", status.message()));
}

}  // namespace

bool HoldsStepResponses(const ModelTable& table) {
  return FoldedKey(table.header.fields.front()) == "time";
}

absl::StatusOr<StepResponseModel> StepResponsesOf(const ModelTable& table) {
  std::vector<ModelTable::PairOfNames> names;
  if (table.inputs.empty()) {
    MLE_ASSIGN_OR_RETURN(names, NamesInHeader(table));
  }
  StepResponseModel model;
  MLE_ASSIGN_OR_RETURN(model.channels, table.Channels(names));
  MLE_ASSIGN_OR_RETURN(const Labels labels, LabelsOf(table, model.channels));
  MLE_RETURN_IF_ERROR(ReadPairColumns(table, labels, model));
  MLE_ASSIGN_OR_RETURN(model.interval, ReadInterval(table));
  MLE_RETURN_IF_ERROR(ReadCoefficients(table, model));
  for (const TableLine& line : table.others) {
    if (line.fields.front() == "ramp") {
      MLE_RETURN_IF_ERROR(ReadRamps(table, line, labels, model));
    } else if (line.fields.front() == "time to steady state") {
      MLE_RETURN_IF_ERROR(CheckSteadyStateLine(table, line, model));
    }
  }
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return table.Fault(table.rows.back().line, std::string(status.message()));
  }
  return model;
}

absl::StatusOr<StepResponseModel> ParseStepResponseCsv(
    std::string_view csv, std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const ModelTable table, ReadModelTable(csv, source));
  if (HoldsStepResponses(table)) return StepResponsesOf(table);
  return table.Fault(table.header.line,
                     "the first field is not 'time': these are not step "
                     "responses");
}

std::string FormatStepResponseCsv(const StepResponseModel& model) {
  std::string text = FormatTableHead(model.channels);
  absl::StrAppend(&text, "interval,", TableNumber(model.interval),
                  "\ntime to steady state,",
                  TableNumber(model.time_to_steady_state()), "\n");
  std::string header = "time";
  std::string ramps;
  for (const PairResponse& pair : model.pairs) {
    const std::string label =
        QuoteCsvField(Label(model.channels, pair.output, pair.input));
    absl::StrAppend(&header, ",", label);
    if (pair.is_ramp) absl::StrAppend(&ramps, ",", label);
  }
  if (!ramps.empty()) absl::StrAppend(&text, "ramp", ramps, "\n");
  absl::StrAppend(&text, header, "\n");
  for (int k = 0; k < model.length(); ++k) {
    absl::StrAppendFormat(&text, "%.12g", (k + 1) * model.interval);
    for (const PairResponse& pair : model.pairs) {
      absl::StrAppend(&text, ",", TableNumber(pair.coefficients(k)));
    }
    text += '\n';
  }
  return text;
}

absl::StatusOr<StepResponseModel> ParseStepResponseJson(
    std::string_view json, std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json parsed,
                       ParseStrictJson(json, source));
  const JsonNode top(parsed, std::string(source));
  MLE_RETURN_IF_ERROR(top.CheckKeys(
      {"name", "time_unit", "inputs", "outputs", "interval", "step_responses"},
      {"time_to_steady_state"}));
  StepResponseModel model;
  MLE_ASSIGN_OR_RETURN(model.channels, ReadChannels(top));
  MLE_ASSIGN_OR_RETURN(model.interval, top.At("interval").Number(kPositive));
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At("step_responses").Elements());
  for (const JsonNode& node : nodes) {
    MLE_RETURN_IF_ERROR(ReadPair(node, model));
  }
  MLE_RETURN_IF_ERROR(CheckSteadyState(top, model));
  MLE_RETURN_IF_ERROR(top.Check(model.Validate()));
  return model;
}

std::string FormatStepResponseJson(const StepResponseModel& model) {
  std::vector<std::string> pairs;
  for (const PairResponse& pair : model.pairs) {
    pairs.push_back(absl::StrCat(
        "\"output\": ", QuotedJson(model.channels.outputs()[pair.output].name),
        ", \"input\": ", QuotedJson(model.channels.inputs()[pair.input].name),
        pair.is_ramp ? ", \"end\": \"ramp\"" : "", ",\n     \"coefficients\": ",
        FormatNumbers({pair.coefficients.begin(), pair.coefficients.end()})));
  }
  return absl::StrCat("{\n", FormatChannels(model.channels),
                      ",\n  \"interval\": ", ShortestNumber(model.interval),
                      ",\n  \"time_to_steady_state\": ",
                      ShortestNumber(model.time_to_steady_state()),
                      ",\n  \"step_responses\": ", FormatJsonObjects(pairs),
                      "\n}\n");
}

absl::StatusOr<StepResponseModel> ParseStepResponseModel(
    std::string_view text, std::string_view source) {
  return IsJsonText(text) ? ParseStepResponseJson(text, source)
                          : ParseStepResponseCsv(text, source);
}

absl::StatusOr<StepResponseModel> ReadStepResponseModel(
    const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  return ParseStepResponseModel(text, path);
}

}  // namespace mle
