#include "mle/data/nearest_names.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/data/csv_rows.h"

namespace mle {
namespace {

// Longer names are compared by their beginnings.
constexpr std::size_t kMaxLength = 64;
constexpr std::size_t kMinPart = 2;

}  // namespace

std::string FoldedName(std::string_view name) {
  std::string folded;
  for (const char c : name) {
    if (c == ' ' || c == '\t') continue;
    folded +=
        static_cast<char>(absl::ascii_tolower(static_cast<unsigned char>(c)));
  }
  return folded;
}

int NameDistance(std::string_view left, std::string_view right) {
  const std::string a = FoldedName(left).substr(0, kMaxLength);
  const std::string b = FoldedName(right).substr(0, kMaxLength);
  // Three rows of the table: of the letters before the last, the last, this.
  std::vector<int> before(b.size() + 1);
  std::vector<int> last(b.size() + 1);
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int change = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
  }
  return row[b.size()];
}

std::vector<std::string> NearestNames(std::string_view name,
                                      const std::vector<std::string>& names,
                                      std::size_t most) {
  const std::string wanted = FoldedName(name);
  std::vector<std::pair<int, std::string>> near;
  for (const std::string& candidate : names) {
    const std::string folded = FoldedName(candidate);
    const std::size_t shorter = std::min(folded.size(), wanted.size());
    const bool is_part =
        shorter >= kMinPart && (folded.find(wanted) != std::string::npos ||
                                wanted.find(folded) != std::string::npos);
    const int distance = NameDistance(name, candidate);
    const int allowed =
        static_cast<int>(
            std::min(std::max(wanted.size(), folded.size()), kMaxLength)) /
        3;
    if (is_part || distance <= allowed) near.emplace_back(distance, candidate);
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return a.first < b.first;
  });
  std::vector<std::string> nearest;
  for (const auto& [distance, candidate] : near) {
    if (nearest.size() == most) break;
    nearest.push_back(candidate);
  }
  return nearest;
}

std::string ListOfNames(const std::vector<std::string>& names) {
  std::vector<std::string> shown;
  for (const std::string& name : names) {
    if (shown.size() == kShownNames) break;
    shown.push_back(absl::StrCat("'", ShowCsvText(name), "'"));
  }
  return absl::StrCat(
      absl::StrJoin(shown, ", "),
      names.size() > shown.size()
          ? absl::StrCat(" and ", names.size() - shown.size(), " more")
          : "");
}

}  // namespace mle
