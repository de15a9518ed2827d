#include "apps/correct/result.h"

#include <iostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "apps/correct/advice.h"
#include "apps/correct/checksum.h"
#include "apps/correct/verdict.h"
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

}  // namespace

int Result::exit_code() const {
  return usable() && decision != Decision::kCannotTell ? 0 : 1;
}

absl::StatusOr<std::vector<DataFile>> ReadChecksums(
    const std::vector<std::string>& paths) {
  std::vector<DataFile> files;
  for (const std::string& path : paths) {
    const absl::StatusOr<FileChecksum> checksum = ChecksumOf(path);
    if (!checksum.ok()) {
      return absl::Status(
          checksum.status().code(),
          absl::StrCat("--data: ", checksum.status().message()));
    }
    files.push_back({path, checksum->sha256, checksum->bytes});
  }
  return files;
}

absl::StatusOr<Result> RunCorrection(const Request& request, RecordData data,
                                     std::vector<DataFile> files) {
  Result result;
  result.request = request;
  result.files = std::move(files);
  CorrectOptions options = request.options;
  options.progress = [](const RunProgress& progress) {
    if (progress.fraction == 0.0) std::cerr << progress.stage << " …\n";
    return true;
  };
  MLE_ASSIGN_OR_RETURN(
      static_cast<CorrectionResult&>(result),
      CorrectFromData(request.model, std::move(data), options));
  CompareWithTruth(result);
  result.verdict = DescribeVerdict(result);
  result.findings = Findings(result);
  result.advice = Advise(result);
  result.tuning = AdviseTuning(result);
  return result;
}

absl::Status NameFlags(const absl::Status& status) {
  const std::string options = OptionOf(status);
  if (options.empty()) return status;
  std::vector<std::pair<std::string, std::string>> flags;
  const std::vector<std::string> names = absl::StrSplit(options, ',');
  for (const std::string& option : names) {
    const std::string flag = absl::StrCat("--", option);
    flags.emplace_back(option + " = ", flag + "=");
    flags.emplace_back(option, flag);
  }
  return absl::Status(status.code(),
                      absl::StrReplaceAll(status.message(), flags));
}

std::string Shown(const Message& message) {
  if (message.options.empty()) return message.text;
  return absl::StrCat(message.text, " (--",
                      absl::StrJoin(message.options, ", --"), ")");
}

}  // namespace mle::correct
