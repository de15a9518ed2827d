#include <algorithm>

#include "absl/strings/str_cat.h"
#include "apps/common/option_table.h"
#include "apps/correct/request.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "nlohmann/json.hpp"

namespace mle::correct {
namespace {

using ParsedJson = nlohmann::json;

constexpr int kVersion = 3;

std::string TextAt(const ParsedJson& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>()
                                                     : "";
}

// False where the value or its interval is missing.
bool ReadEstimate(const ParsedJson& element, const char* name,
                  PreviousEstimate& estimate) {
  const auto parameter = element.find(name);
  if (parameter == element.end() || !parameter->is_object()) return false;
  const auto free = parameter->find("all_free");
  if (free == parameter->end() || !free->is_object()) return false;
  for (const auto& [key, number] :
       {std::pair<const char*, double*>{"value", &estimate.value},
        {"lower", &estimate.lower},
        {"upper", &estimate.upper}}) {
    const auto found = free->find(key);
    if (found == free->end() || !found->is_number()) return false;
    *number = found->get<double>();
  }
  return true;
}

template <typename Channels>
bool HasName(const Channels& channels, const std::string& name) {
  return std::any_of(channels.begin(), channels.end(),
                     [&](const auto& channel) { return channel.name == name; });
}

absl::Status ReadElements(const ParsedJson& elements, const ProcessModel& model,
                          PreviousRun& run) {
  for (const ParsedJson& element : elements) {
    PreviousEstimate estimate;
    estimate.output = TextAt(element, "output");
    estimate.input = TextAt(element, "input");
    if (!HasName(model.outputs(), estimate.output) ||
        !HasName(model.inputs(), estimate.input)) {
      return InvalidArgument("it is of another model: '", estimate.output,
                             " ← ", estimate.input, "' is not in this one");
    }
    for (const char* const name : {"gain", "time_constant", "delay"}) {
      if (!ReadEstimate(element, name, estimate)) continue;
      estimate.name = name;
      run.estimates.push_back(estimate);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PreviousRun> ReadPreviousRun(const std::string& folder,
                                            const ProcessModel& model) {
  const std::string path = folder + "/result.json";
  const auto wrong = [&](absl::string_view what) {
    return InvalidArgument("--previous: '", path, "': ", what);
  };
  MLE_ASSIGN_OR_RETURN(const std::string text,
                       AboutOption("previous", ReadFile(path)));
  const ParsedJson json =
      ParsedJson::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || TextAt(json, "program") != "mle_correct") {
    return wrong("it is not a result of mle_correct");
  }
  if (json.value("version", ParsedJson()) != kVersion) {
    return wrong(absl::StrCat("its version is not ", kVersion));
  }
  PreviousRun run;
  run.folder = folder;
  run.decision = TextAt(json, "decision");
  const auto windows = json.find("windows");
  if (windows != json.end() && windows->is_array() && !windows->empty()) {
    run.until = TextAt(windows->back(), "to_date").substr(0, 10);
  }
  const auto elements = json.find("elements");
  if (elements == json.end() || !elements->is_array()) {
    return wrong("it has no elements");
  }
  if (const absl::Status status = ReadElements(*elements, model, run);
      !status.ok()) {
    return wrong(status.message());
  }
  return run;
}

}  // namespace mle::correct
