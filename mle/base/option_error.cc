#include "mle/base/option_error.h"

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"

namespace mle {
namespace {

constexpr char kOptionUrl[] = "mle/option";

absl::string_view Absl(std::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace

absl::Status OptionError(std::string_view option, std::string_view text) {
  absl::Status status = absl::InvalidArgumentError(Absl(text));
  status.SetPayload(kOptionUrl, absl::Cord(Absl(option)));
  return status;
}

std::string OptionOf(const absl::Status& status) {
  const absl::optional<absl::Cord> option = status.GetPayload(kOptionUrl);
  return option.has_value() ? std::string(*option) : "";
}

absl::Status WithPrefix(const absl::Status& status, std::string_view prefix) {
  absl::Status result(status.code(),
                      absl::StrCat(Absl(prefix), status.message()));
  if (const std::string option = OptionOf(status); !option.empty()) {
    result.SetPayload(kOptionUrl, absl::Cord(option));
  }
  return result;
}

}  // namespace mle
