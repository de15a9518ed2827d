#include "apps/correct/result.h"

#include <map>
#include <set>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "apps/correct/report.h"
#include "mle/base/option_error.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::correct {
namespace {

void CompareWithTruth(Result& result) {
  if (!result.request.truth.has_value()) return;
  const StepResponse& initial = result.initial_response;
  result.true_response = result.request.truth->ComputeStepResponse(
      initial.sample_time, initial.samples());
  result.initial_to_truth = CompareResponses(*result.true_response, initial);
  result.corrected_to_truth =
      CompareResponses(*result.true_response, result.corrected.response);
}

// Parts of names and paths: "tags" is no option in "my_tags" and "tags.csv".
bool IsPartOfName(std::string_view text, std::size_t at) {
  if (at >= text.size()) return false;
  const char c = text[at];
  const bool before_more = at + 1 < text.size() && text[at + 1] != ' ';
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' ||
         c == '-' || c == '/' || c == '\'' || (c == '.' && before_more);
}

// "name = value" and "name" become "--name=value" and "--name". Where a value
// is given, a name without an underline, such as decimal, may be a word
// elsewhere.
std::string NameFlag(std::string_view text, const std::string& name) {
  constexpr std::string_view kEquals = " = ";
  const bool may_be_word =
      name.find('_') == std::string::npos &&
      text.find(name + std::string(kEquals)) != std::string_view::npos;
  std::string result;
  std::size_t done = 0;
  for (std::size_t at = text.find(name); at != std::string_view::npos;
       at = text.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    const bool is_part =
        (at > 0 && IsPartOfName(text, at - 1)) || IsPartOfName(text, end);
    const bool is_word = may_be_word && !text.substr(end).starts_with(kEquals);
    if (is_part || is_word || at < done) continue;
    result.append(text.substr(done, at - done));
    absl::StrAppend(&result, "--", name);
    done = end;
    if (text.substr(end).starts_with(kEquals)) {
      result += '=';
      done += kEquals.size();
    }
  }
  result.append(text.substr(done));
  return result;
}

// Warns where the model in the form of the one given differs from the corrected
// model.
absl::Status WarnOfDifferences(Result& result) {
  const ModelFile& file = result.request.model_file;
  if (CorrectedName(file).empty()) return absl::OkStatus();
  const ProcessModel whole = InWholeModel(result.request, result.model);
  MLE_ASSIGN_OR_RETURN(const FormattedModel as_given,
                       FormatCorrected(file, whole));
  for (const PairDescription& pair : as_given.differences) {
    const std::string name = PairName(whole, pair.output, pair.input);
    result.warnings.push_back(
        {MessageCode::kImport,
         name,
         absl::StrFormat(
             "In %s the element of %s is the nearest of second order, and its "
             "step response differs by %.3g %% of its range; model.json has "
             "the element itself.",
             as_given.name, name, 100.0 * pair.largest_difference),
         {}});
  }
  return absl::OkStatus();
}

// Messages of one kind from which on they are told as one.
constexpr std::size_t kTogether = 3;

// Of messages about a window or an output each, behind their number; null for
// others.
const char* OfSeveral(MessageCode code) {
  switch (code) {
    case MessageCode::kWindowNotAtRest:
      return "windows are not at rest where they should be; unmeasured "
             "disturbances widen the intervals.";
    case MessageCode::kWindowCut:
      return "windows are cut to their longest parts without missing inputs.";
    case MessageCode::kWindowDropped:
      return "windows are left out.";
    case MessageCode::kUnmeasured:
      return "outputs have samples as far from the model's prediction as "
             "outliers, which are too many to be outliers and are used.";
    default:
      return nullptr;
  }
}

}  // namespace

int Result::exit_code() const {
  return usable() && decision != Decision::kCannotTell ? 0 : 1;
}

std::vector<std::pair<std::string, std::string>> Checksums(
    const Result& result) {
  std::vector<std::pair<std::string, std::string>> checksums;
  for (const DataFile& file : result.files) {
    checksums.emplace_back(absl::StrCat("SHA-256 of ", file.path), file.sha256);
  }
  return checksums;
}

std::vector<Message> DescriptionWarnings(const ModelFile& file) {
  std::vector<Message> warnings;
  for (const std::string& difference : NotableDifferences(file)) {
    warnings.push_back({MessageCode::kImport, "", difference, {}});
  }
  return warnings;
}

absl::StatusOr<Result> RunCorrection(const Request& request, RecordData data,
                                     std::vector<DataFile> files) {
  Result result;
  result.request = request;
  result.files = std::move(files);
  NameFlags(data);
  CorrectOptions options = request.options;
  options.filter = FilterOptionsOf(request);
  MLE_ASSIGN_OR_RETURN(
      static_cast<CorrectionResult&>(result),
      CorrectFromData(request.model, std::move(data), options));
  MLE_RETURN_IF_ERROR(WarnOfDifferences(result));
  for (Message& warning : DescriptionWarnings(request.model_file)) {
    result.warnings.push_back(std::move(warning));
  }
  result.warnings.insert(result.warnings.begin(), request.left_out.begin(),
                         request.left_out.end());
  CompareWithTruth(result);
  result.filter_operation = CompareFilters(result);
  result.verdict = DescribeVerdict(result);
  result.findings = Findings(result);
  result.advice = Advise(result);
  // Each by itself leaves threads idle.
  Tuning tuning;
  absl::StatusOr<LoopComparison> loops;
  ParallelFor(2, result.options.threads, [&](int part) {
    if (part == 0) {
      tuning = AdviseTuning(result);
    } else {
      loops = CompareLoops(result);
    }
  });
  result.tuning = std::move(tuning);
  result.loops = std::move(loops);
  if (request.next_move.wanted) {
    MLE_ASSIGN_OR_RETURN(result.next_move, PlanNextMove(result));
  }
  return result;
}

absl::Status NameFlags(const absl::Status& status) {
  const std::string options = OptionOf(status);
  if (options.empty()) return status;
  std::string text(status.message());
  const std::vector<std::string> names = absl::StrSplit(options, ',');
  for (const std::string& name : names) text = NameFlag(text, name);
  return absl::Status(status.code(), text);
}

void NameFlags(RecordData& data) {
  const auto rename = [](Message& message) {
    if (message.code != MessageCode::kMistake) return;
    for (const char* name : {"tags", "number_unit"}) {
      if (absl::StrContains(message.text, absl::StrCat(name, " = "))) {
        message.text = NameFlag(message.text, name);
      }
    }
  };
  for (Message& obstacle : data.obstacles) rename(obstacle);
  for (mle::Finding& finding : data.findings) rename(finding.message);
}

std::string Shown(const Message& message) {
  if (message.options.empty()) return message.text;
  return absl::StrCat(message.text, " (--",
                      absl::StrJoin(message.options, ", --"), ")");
}

std::vector<std::string> ShownTogether(const std::vector<Message>& messages) {
  std::map<MessageCode, std::vector<std::string>> places_of;
  for (const Message& message : messages) {
    if (!message.place.empty()) {
      places_of[message.code].push_back(message.place);
    }
  }
  std::vector<std::string> texts;
  std::set<MessageCode> told;
  for (const Message& message : messages) {
    const std::vector<std::string>& places = places_of[message.code];
    const char* const words = OfSeveral(message.code);
    if (words == nullptr || message.place.empty() ||
        places.size() < kTogether) {
      texts.push_back(Shown(message));
    } else if (told.insert(message.code).second) {
      Message all = message;
      all.text = absl::StrCat(places.size(), " ", words,
                              " Among them: ", places[0], ", ", places[1], ".");
      texts.push_back(Shown(all));
    }
  }
  return texts;
}

}  // namespace mle::correct
