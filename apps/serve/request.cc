#include "apps/serve/request.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace mle::serve {
namespace {

constexpr absl::string_view kLineEnd = "\r\n";
constexpr std::size_t kLengthDigits = 10;

bool IsTokenCharacter(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
         std::string_view("!#$%&'*+-.^_`|~").find(c) != absl::string_view::npos;
}

bool IsToken(absl::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), IsTokenCharacter);
}

// Visible ASCII.
bool IsVisible(char c) { return c > ' ' && c < '\x7f'; }

// Blanks and tabs may stand in the value of a header; other control characters
// may not.
bool IsOfValue(char c) {
  return static_cast<unsigned char>(c) >= 0x80 || IsVisible(c) || c == ' ' ||
         c == '\t';
}

class HeadParser {
 public:
  explicit HeadParser(absl::string_view head) : rest_(head) {}

  ParsedHead Parse() {
    absl::string_view line;
    if (!TakeLine(line) || !ParseRequestLine(line)) return Result();
    while (TakeLine(line)) {
      if (line.empty()) {
        Finish();
        return Result();
      }
      if (!ParseHeader(line)) return Result();
    }
    return Result();
  }

 private:
  bool Refuse(int status, std::string fault) {
    head_.status = status;
    head_.fault = std::move(fault);
    return false;
  }

  ParsedHead Result() { return std::move(head_); }

  bool TakeLine(absl::string_view& line) {
    const std::size_t end = rest_.find(kLineEnd);
    if (end == absl::string_view::npos) {
      return Refuse(400, "The head of the request does not end.");
    }
    line = rest_.substr(0, end);
    rest_.remove_prefix(end + kLineEnd.size());
    return true;
  }

  bool ParseRequestLine(absl::string_view line) {
    const std::vector<absl::string_view> parts = absl::StrSplit(line, ' ');
    if (parts.size() != 3 || !IsToken(parts[0])) {
      return Refuse(400, "The request line is not METHOD TARGET HTTP/1.1.");
    }
    const absl::string_view target = parts[1];
    if (target.size() > kMostTarget) {
      return Refuse(414, "The target of the request is too long.");
    }
    if (target.empty() || target[0] != '/' ||
        !std::all_of(target.begin(), target.end(), IsVisible)) {
      return Refuse(400, "The target of the request is not a path.");
    }
    if (parts[2] != "HTTP/1.1" && parts[2] != "HTTP/1.0") {
      return Refuse(parts[2].substr(0, 5) == "HTTP/" ? 505 : 400,
                    "The version is not HTTP/1.1.");
    }
    Request& request = head_.request;
    request.method = std::string(parts[0]);
    request.keep_alive = is_current_ = parts[2] == "HTTP/1.1";
    const std::size_t query = target.find('?');
    request.path = std::string(target.substr(0, query));
    if (query == absl::string_view::npos) return true;
    std::optional<std::map<std::string, std::string>> decoded =
        ParseForm(target.substr(query + 1));
    if (!decoded.has_value()) {
      return Refuse(400, "The query cannot be decoded.");
    }
    request.query = *std::move(decoded);
    return true;
  }

  bool ParseHeader(absl::string_view line) {
    if (++headers_ > kMostHeaders) {
      return Refuse(431, "The request has too many headers.");
    }
    const std::size_t colon = line.find(':');
    if (colon == absl::string_view::npos || !IsToken(line.substr(0, colon))) {
      return Refuse(400, "A header is not NAME: VALUE.");
    }
    const std::string name = absl::AsciiStrToLower(line.substr(0, colon));
    const absl::string_view value =
        absl::StripAsciiWhitespace(line.substr(colon + 1));
    if (!std::all_of(value.begin(), value.end(), IsOfValue)) {
      return Refuse(400, "A header holds control characters.");
    }
    return TakeHeader(name, value);
  }

  // What is not known is left out.
  bool TakeHeader(const std::string& name, absl::string_view value) {
    Request& request = head_.request;
    const std::pair<absl::string_view, std::string*> kept[] = {
        {"host", &request.host},
        {"origin", &request.origin},
        {"sec-fetch-site", &request.fetch_site},
        {"authorization", &request.authorization},
        {"content-type", &request.content_type}};
    for (const auto& [known, field] : kept) {
      if (name != known) continue;
      if (!once_.insert(name).second) {
        return Refuse(400, absl::StrCat("The header ", known, " is repeated."));
      }
      *field = std::string(value);
      return true;
    }
    if (name == "content-length") return TakeLength(value);
    if (name == "transfer-encoding") {
      return Refuse(411, "A body must come with its Content-Length.");
    }
    if (name == "expect") return Refuse(417, "Expect is not supported.");
    if (name == "connection") TakeConnection(value);
    return true;
  }

  bool TakeLength(absl::string_view value) {
    if (!once_.insert("content-length").second || value.empty() ||
        !std::all_of(value.begin(), value.end(), [](char c) {
          return absl::ascii_isdigit(static_cast<unsigned char>(c));
        })) {
      return Refuse(400, "Content-Length is not one number.");
    }
    std::uint64_t bytes = 0;
    if (value.size() > kLengthDigits || !absl::SimpleAtoi(value, &bytes) ||
        bytes > kMostBody) {
      return Refuse(413, "The body of the request is too long.");
    }
    head_.request.body_bytes = static_cast<std::size_t>(bytes);
    return true;
  }

  void TakeConnection(absl::string_view value) {
    for (absl::string_view part : absl::StrSplit(value, ',')) {
      part = absl::StripAsciiWhitespace(part);
      if (absl::EqualsIgnoreCase(part, "close"))
        head_.request.keep_alive = false;
      if (absl::EqualsIgnoreCase(part, "keep-alive")) {
        head_.request.keep_alive = true;
      }
    }
  }

  void Finish() {
    const Request& request = head_.request;
    if (request.host.empty() && (is_current_ || once_.contains("host"))) {
      Refuse(400, "The request has no Host.");
    } else if (request.body_bytes > 0 && request.method != "POST") {
      Refuse(400, "Only POST has a body.");
    }
  }

  absl::string_view rest_;
  ParsedHead head_;
  std::set<std::string> once_;
  int headers_ = 0;
  bool is_current_ = true;
};

}  // namespace

ParsedHead ParseHead(absl::string_view head) {
  return HeadParser(head).Parse();
}

std::optional<std::string> DecodePercent(absl::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+') {
      out += ' ';
    } else if (text[i] != '%') {
      out += text[i];
    } else {
      unsigned byte = 0;
      if (i + 2 >= text.size() ||
          !absl::ascii_isxdigit(static_cast<unsigned char>(text[i + 1])) ||
          !absl::ascii_isxdigit(static_cast<unsigned char>(text[i + 2])) ||
          !absl::SimpleHexAtoi(text.substr(i + 1, 2), &byte)) {
        return std::nullopt;
      }
      out += static_cast<char>(byte);
      i += 2;
    }
  }
  return out;
}

std::optional<std::map<std::string, std::string>> ParseForm(
    absl::string_view text) {
  std::map<std::string, std::string> fields;
  for (const absl::string_view part :
       absl::StrSplit(text, '&', absl::SkipEmpty())) {
    const std::pair<absl::string_view, absl::string_view> field =
        absl::StrSplit(part, absl::MaxSplits('=', 1));
    const std::optional<std::string> name = DecodePercent(field.first);
    std::optional<std::string> value = DecodePercent(field.second);
    if (!name.has_value() || !value.has_value()) return std::nullopt;
    fields[*name] = *std::move(value);
  }
  return fields;
}

}  // namespace mle::serve
