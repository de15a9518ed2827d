#include "apps/serve/request.h"

#include <algorithm>
#include <cstdint>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace mle::serve {
namespace {

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
  ParsedHead Parse(const Head& head) && {
    if (ParseRequestLine(head) && ParseHeaders(head)) CheckWhole(head);
    return std::move(parsed_);
  }

 private:
  bool Refuse(int status, std::string fault) {
    parsed_.status = status;
    parsed_.fault = std::move(fault);
    return false;
  }

  bool ParseRequestLine(const Head& head) {
    if (!IsToken(head.method)) {
      return Refuse(400, "The request line is not METHOD TARGET HTTP/1.1.");
    }
    const absl::string_view target = head.target;
    if (target.size() > kMostTarget) {
      return Refuse(414, "The target of the request is too long.");
    }
    if (target.empty() || target[0] != '/' ||
        !std::all_of(target.begin(), target.end(), IsVisible)) {
      return Refuse(400, "The target of the request is not a path.");
    }
    if (head.version != "HTTP/1.1" && head.version != "HTTP/1.0") {
      return Refuse(505, "The version is not HTTP/1.1.");
    }
    Request& request = parsed_.request;
    request.method = std::string(head.method);
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

  bool ParseHeaders(const Head& head) {
    if (head.headers.size() > kMostHeaders) {
      return Refuse(431, "The request has too many headers.");
    }
    for (const auto& [name, value] : head.headers) {
      if (!IsToken(name)) return Refuse(400, "A header is not NAME: VALUE.");
      if (!std::all_of(value.begin(), value.end(), IsOfValue)) {
        return Refuse(400, "A header holds control characters.");
      }
      if (!TakeHeader(absl::AsciiStrToLower(name),
                      absl::StripAsciiWhitespace(value))) {
        return false;
      }
    }
    return true;
  }

  // Other headers than these are left out.
  bool TakeHeader(const std::string& name, absl::string_view value) {
    Request& request = parsed_.request;
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
    parsed_.request.body_bytes = static_cast<std::size_t>(bytes);
    return true;
  }

  bool CheckWhole(const Head& head) {
    const Request& request = parsed_.request;
    if (request.host.empty() &&
        (head.version == "HTTP/1.1" || once_.contains("host"))) {
      return Refuse(400, "The request has no Host.");
    }
    if (request.body_bytes > 0 && request.method != "POST") {
      return Refuse(400, "Only POST has a body.");
    }
    return true;
  }

  ParsedHead parsed_;
  std::set<std::string> once_;
};

}  // namespace

ParsedHead ParseHead(const Head& head) { return HeadParser().Parse(head); }

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
