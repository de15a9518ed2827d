#include "apps/common/part.h"

#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "apps/common/sha256.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr int kMostParts = 100'000;
constexpr std::size_t kHexDigits = 12;

}  // namespace

bool Part::Has(std::string_view name) const {
  const std::string hash = Sha256Of(name).substr(0, kHexDigits);
  std::int64_t value = 0;
  return absl::SimpleHexAtoi(hash, &value) && Has(value);
}

std::string Part::FolderBelow(const std::string& folder) const {
  return is_everything()
             ? folder
             : absl::StrCat(folder, "/parts/", number, "-of-", count);
}

absl::StatusOr<Part> ParsePart(const std::string& text) {
  Part part;
  if (text.empty()) return part;
  const std::vector<std::string> numbers = absl::StrSplit(text, '/');
  if (numbers.size() != 2 || !absl::SimpleAtoi(numbers[0], &part.number) ||
      !absl::SimpleAtoi(numbers[1], &part.count) || part.number < 1 ||
      part.count > kMostParts || part.number > part.count) {
    return InvalidArgument(
        "it must be a number and how many there are, such as 3/16; at most ",
        kMostParts, " parts");
  }
  part.text = absl::StrCat(part.number, "/", part.count);
  return part;
}

TextValue PartOfWork(Part* part) {
  return {.text = part->text,
          .read = [part](const std::string& given, const NumberRange&) {
            MLE_ASSIGN_OR_RETURN(*part, ParsePart(given));
            return absl::OkStatus();
          }};
}

}  // namespace mle
