#include "mle/model/strict_json.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;
constexpr std::size_t kMaxDepth = 64;

// "line 3, column 14" of the byte before `position`, counted from 1.
std::string LineAndColumn(std::string_view text, std::size_t position) {
  const std::string_view before =
      text.substr(0, std::min(position == 0 ? 0 : position - 1, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0.
  return absl::StrCat("line ", line, ", column ",
                      before.size() - line_start + 1);
}

// Walks through a text and stops at its first fault.
class Checker : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Checker(std::string_view text) : text_(text) {}

  const std::string& fault() const { return fault_; }

  bool null() override { return Value(); }
  bool boolean(bool) override { return Value(); }
  bool number_integer(number_integer_t) override { return Value(); }
  bool number_unsigned(number_unsigned_t) override { return Value(); }
  bool number_float(number_float_t, const string_t&) override {
    return Value();
  }
  bool string(string_t&) override { return Value(); }
  bool binary(binary_t&) override { return Value(); }
  bool start_object(std::size_t) override { return Open(/*is_array=*/false); }
  bool start_array(std::size_t) override { return Open(/*is_array=*/true); }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }

  bool key(string_t& name) override {
    Level& level = levels_.back();
    if (!level.keys.insert(name).second) {
      std::string place;
      for (std::size_t i = 0; i + 1 < levels_.size(); ++i) {
        absl::StrAppend(&place, levels_[i].Step(place.empty()));
      }
      fault_ = absl::StrCat(place, place.empty() ? "" : ": ", "key \"", name,
                            "\" is duplicated; give each key once");
      return false;
    }
    level.last_key = name;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& last_token,
                   const nlohmann::json::exception& error) override {
    std::string reason = error.what();
    // "[json.exception.parse_error.101] parse error at line 1, column 2: …"
    const std::size_t colon = reason.find(": ");
    const std::size_t bracket = reason.find("] ");
    if (error.id == 406) {
      reason = absl::StrCat("number ", last_token, " is out of range");
    } else if (colon != std::string::npos) {
      reason = reason.substr(colon + 2);
    } else if (bracket != std::string::npos) {
      reason = reason.substr(bracket + 2);
    }
    fault_ = absl::StrCat(LineAndColumn(text_, position), ": ", reason);
    return false;
  }

 private:
  struct Level {
    bool is_array = false;
    std::int64_t index = -1;  // Of the present element of an array.
    std::string last_key;
    std::set<std::string> keys;

    std::string Step(bool first) const {
      if (is_array) return absl::StrCat("[", index, "]");
      return absl::StrCat(first ? "" : ".", last_key);
    }
  };

  bool Value() {
    if (!levels_.empty()) ++levels_.back().index;
    return true;
  }
  bool Open(bool is_array) {
    Value();
    if (levels_.size() == kMaxDepth) {
      fault_ = absl::StrCat("nested deeper than ", kMaxDepth, " levels");
      return false;
    }
    levels_.emplace_back();
    levels_.back().is_array = is_array;
    return true;
  }
  bool Close() {
    levels_.pop_back();
    return true;
  }

  std::string_view text_;
  std::vector<Level> levels_;
  std::string fault_;
};

}  // namespace

absl::StatusOr<nlohmann::json> ParseStrictJson(std::string_view text,
                                               std::string_view source) {
  if (text.size() > kMaxBytes) {
    return InvalidArgument(std::string(source), ": holds ", text.size(),
                           " bytes, at most ", kMaxBytes, " are read");
  }
  try {
    Checker checker(text);
    if (!nlohmann::json::sax_parse(text, &checker)) {
      return InvalidArgument(std::string(source), ": ", checker.fault());
    }
    return nlohmann::json::parse(text);
  } catch (const std::exception& error) {
    return InvalidArgument(std::string(source), ": ", error.what());
  }
}

}  // namespace mle
