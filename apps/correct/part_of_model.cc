#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/option_table.h"
#include "apps/common/option_values.h"
#include "apps/correct/request.h"
#include "mle/base/status.h"
#include "mle/data/historian_file.h"
#include "mle/data/joined_files.h"
#include "mle/data/nearest_names.h"
#include "mle/data/record_columns.h"
#include "mle/maintain/select_output.h"
#include "mle/model/process_model.h"

namespace mle::correct {
namespace {

using Kind = RecordColumn::Kind;

std::string DigitsOf(const std::string& name) {
  std::string digits;
  for (const char c : name) {
    if (absl::ascii_isdigit(static_cast<unsigned char>(c))) digits += c;
  }
  return digits;
}

// FC101 is not FC102 mistyped; FC 101.PV may be FC101.
bool MayBeMeant(const std::string& name,
                const std::vector<std::string>& columns) {
  const std::vector<std::string> near = NearestNames(name, columns);
  return std::any_of(near.begin(), near.end(), [&](const std::string& other) {
    return DigitsOf(name) == DigitsOf(other);
  });
}

// The inputs and outputs whose column, by its tag or by their name, stands in
// no header of the sources, nor one that may be meant by it: a name of the same
// digits that is near or contains it, and is not used otherwise. Errors as of
// an import where a table is not understood.
absl::StatusOr<std::vector<std::string>> MissingChannels(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options) {
  std::set<std::string> unused;
  for (const std::string& name : options.columns.unused_tags) {
    unused.insert(FoldedName(name));
  }
  const std::vector<std::string> wanted_tags =
      WantedTags(channels, options.columns);
  std::map<std::string, std::string> found;  // by their folded names
  for (const HistorianSource& source : sources) {
    MLE_ASSIGN_OR_RETURN(const HistorianColumns columns,
                         HistorianFile::Columns(source, channels, options));
    for (const std::string& name : TagsOf(source, columns, wanted_tags)) {
      if (!unused.contains(FoldedName(name))) found[FoldedName(name)] = name;
    }
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<RecordColumn> known,
                       ColumnsOf(channels));
  std::map<std::string, std::string> wanted;  // the columns, by their channels
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kTime) wanted[column.name] = column.name;
  }
  for (const TagMapping& tag : options.columns.tags) {
    wanted[tag.channel] = tag.tag;
  }
  std::map<std::string, std::string> free = found;
  for (const auto& [channel, column] : wanted) free.erase(FoldedName(column));
  std::vector<std::string> others;
  for (const auto& [folded, name] : free) others.push_back(name);
  std::vector<std::string> missing;
  for (const RecordColumn& column : known) {
    if (column.kind != Kind::kOutput && column.kind != Kind::kInput) continue;
    const std::string& name = wanted.at(column.name);
    // A column of the channel's name is one, whatever tag was declared.
    if (!found.contains(FoldedName(name)) && !MayBeMeant(name, others) &&
        !found.contains(FoldedName(column.name))) {
      missing.push_back(column.name);
    }
  }
  return missing;
}

// Numbers of channels, ascending.
struct Channels {
  std::vector<int> outputs;
  std::vector<int> inputs;
};

// The inputs that move one of these outputs.
Channels WithInputs(const ProcessModel& model, std::vector<int> outputs) {
  Channels part = {std::move(outputs), {}};
  for (int j = 0; j < model.num_inputs(); ++j) {
    const bool moves =
        std::any_of(part.outputs.begin(), part.outputs.end(),
                    [&](int i) { return !model.element(i, j).IsZero(); });
    if (moves) part.inputs.push_back(j);
  }
  return part;
}

// A weight for each pair of channels, of the part.
void TakePart(const std::vector<int>& channels, int all,
              Eigen::MatrixXd& weights) {
  if (weights.rows() != all || weights.cols() != all) return;
  weights = Eigen::MatrixXd(weights(channels, channels));
}

// A value for each channel, of the part.
void TakePart(const std::vector<int>& channels, int all,
              Eigen::VectorXd& values) {
  if (values.size() == all) values = Eigen::VectorXd(values(channels));
}

void TakePart(const Channels& part, const ProcessModel& whole,
              control::MpcOptions& controller) {
  const int p = whole.num_outputs();
  const int m = whole.num_inputs();
  TakePart(part.outputs, p, controller.output_weight);
  TakePart(part.inputs, m, controller.move_weight);
  TakePart(part.outputs, p, controller.disturbance_variance_ratios);
  control::MpcLimits& limits = controller.limits;
  for (Eigen::VectorXd* const of_inputs :
       {&limits.min_input, &limits.max_input, &limits.max_move}) {
    TakePart(part.inputs, m, *of_inputs);
  }
  for (Eigen::VectorXd* const of_outputs :
       {&limits.min_output, &limits.max_output, &limits.output_limit_cost}) {
    TakePart(part.outputs, p, *of_outputs);
  }
}

// The columns of channels that are left out are not needed.
void LeaveOutColumns(const ProcessModel& before, const ProcessModel& after,
                     ColumnOptions& columns) {
  const std::vector<std::string> kept = ChannelNames(after);
  std::set<std::string> left_out;
  for (const std::string& name : ChannelNames(before)) {
    if (std::find(kept.begin(), kept.end(), name) == kept.end()) {
      left_out.insert(name);
    }
  }
  std::vector<TagMapping> tags;
  for (TagMapping& tag : columns.tags) {
    if (left_out.contains(tag.channel)) {
      columns.unused_tags.push_back(tag.tag);
    } else {
      tags.push_back(std::move(tag));
    }
  }
  columns.tags = std::move(tags);
  columns.unused_tags.insert(columns.unused_tags.end(), left_out.begin(),
                             left_out.end());
}

void TakePart(const Channels& part, Request& request) {
  const ProcessModel whole = request.model;
  request.model = SelectPart(whole, part.outputs, part.inputs);
  if (request.truth.has_value()) {
    request.truth = SelectPart(*request.truth, part.outputs, part.inputs);
  }
  TakePart(part, whole, request.controller);
  LeaveOutColumns(whole, request.model, request.import.columns);
}

std::vector<int> OutputsNamed(const ProcessModel& model,
                              const std::set<std::string>& names) {
  std::vector<int> outputs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (names.contains(model.outputs()[i].name)) outputs.push_back(i);
  }
  return outputs;
}

// Why an output cannot be judged; empty if it can.
std::string WhyNot(const ProcessModel& model, int output,
                   const std::set<std::string>& missing) {
  if (missing.contains(model.outputs()[output].name)) {
    return "the records have no column of it";
  }
  std::vector<std::string> inputs;
  for (int j = 0; j < model.num_inputs(); ++j) {
    const std::string& name = model.inputs()[j].name;
    if (!model.element(output, j).IsZero() && missing.contains(name)) {
      inputs.push_back(name);
    }
  }
  if (inputs.empty()) return "";
  return absl::StrCat("the records have no column of ",
                      absl::StrJoin(inputs, " and "), ", which ",
                      inputs.size() == 1 ? "moves" : "move", " it");
}

}  // namespace

absl::Status ChooseOutputs(Request& request) {
  if (request.outputs.empty()) return absl::OkStatus();
  const std::vector<std::string> known = NamesOf(request.model.outputs());
  for (const std::string& name : request.outputs) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    return RefuseOption("outputs", name,
                        absl::StrCat(DidYouMean(name, known),
                                     "the model has no such output; it has ",
                                     absl::StrJoin(known, ", ")));
  }
  const std::set<std::string> chosen(request.outputs.begin(),
                                     request.outputs.end());
  TakePart(WithInputs(request.model, OutputsNamed(request.model, chosen)),
           request);
  return absl::OkStatus();
}

bool LeaveOutMissing(const std::vector<HistorianSource>& sources,
                     Request& request) {
  const absl::StatusOr<std::vector<std::string>> found =
      MissingChannels(sources, request.model, request.import);
  if (!found.ok() || found->empty()) return false;
  const std::set<std::string> missing(found->begin(), found->end());
  std::vector<int> kept;
  std::vector<Message> left_out;
  for (int i = 0; i < request.model.num_outputs(); ++i) {
    const std::string why = WhyNot(request.model, i, missing);
    if (why.empty()) {
      kept.push_back(i);
      continue;
    }
    const std::string& name = request.model.outputs()[i].name;
    left_out.push_back({MessageCode::kImport,
                        name,
                        absl::StrCat(name, " is not judged: ", why, "."),
                        {"tags"}});
  }
  if (kept.empty() || left_out.empty()) return false;
  TakePart(WithInputs(request.model, std::move(kept)), request);
  request.left_out = std::move(left_out);
  return true;
}

ProcessModel InWholeModel(const Request& request, const ProcessModel& part) {
  ProcessModel whole = request.model_file.process;
  std::map<std::string, int> outputs;
  std::map<std::string, int> inputs;
  for (int i = 0; i < whole.num_outputs(); ++i) {
    outputs[whole.outputs()[i].name] = i;
  }
  for (int j = 0; j < whole.num_inputs(); ++j) {
    inputs[whole.inputs()[j].name] = j;
  }
  for (const auto& [i, j] : Pairs(part)) {
    whole.element(outputs.at(part.outputs()[i].name),
                  inputs.at(part.inputs()[j].name)) = part.element(i, j);
  }
  return whole;
}

}  // namespace mle::correct
