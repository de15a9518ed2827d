#include "apps/report/svg.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "apps/report/text.h"
#include "mle/base/status.h"

namespace mle::report {
namespace {

constexpr double kLargestScale = 1.4;
// Below this the text of a figure is too small to read on a telephone: the
// page lets it be scrolled instead.
constexpr double kSmallestScale = 0.85;

struct Attribute {
  std::string name;
  std::string value;  // as written, entities and all
};

struct Tag {
  std::string name;  // "g", "/g"
  std::vector<Attribute> attributes;
  bool closed = false;  // <g/>
};

bool IsSpace(char c) { return std::isspace(static_cast<unsigned char>(c)); }

absl::Status Malformed(const std::string& what) {
  return absl::InvalidArgumentError("the picture is no SVG to embed: " + what);
}

// Reads what stands between < and >.
absl::StatusOr<Tag> ParseTag(std::string_view text) {
  Tag tag;
  if (!text.empty() && text.back() == '/') {
    tag.closed = true;
    text.remove_suffix(1);
  }
  std::size_t at = 0;
  while (at < text.size() && !IsSpace(text[at])) tag.name += text[at++];
  while (true) {
    while (at < text.size() && IsSpace(text[at])) ++at;
    if (at == text.size()) return tag;
    Attribute attribute;
    while (at < text.size() && text[at] != '=' && !IsSpace(text[at])) {
      attribute.name += text[at++];
    }
    while (at < text.size() && IsSpace(text[at])) ++at;
    if (at == text.size() || text[at] != '=') {
      return Malformed("attribute " + attribute.name + " has no value");
    }
    ++at;
    while (at < text.size() && IsSpace(text[at])) ++at;
    if (at == text.size() || (text[at] != '"' && text[at] != '\'')) {
      return Malformed("attribute " + attribute.name + " is not quoted");
    }
    const std::size_t end = text.find(text[at], at + 1);
    if (end == std::string_view::npos) {
      return Malformed("attribute " + attribute.name + " has no end");
    }
    attribute.value = std::string(text.substr(at + 1, end - at - 1));
    at = end + 1;
    tag.attributes.push_back(std::move(attribute));
  }
}

// The end of the tag that opens at `at`; quoted > do not count.
std::size_t EndOfTag(std::string_view svg, std::size_t at) {
  char quote = 0;
  for (; at < svg.size(); ++at) {
    const char c = svg[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at;
    }
  }
  return std::string_view::npos;
}

absl::Status CheckPassive(const Tag& tag) {
  for (const std::string_view active :
       {"script", "foreignObject", "iframe", "image", "style", "a"}) {
    if (tag.name == active) return Malformed("it holds <" + tag.name + ">");
  }
  for (const Attribute& attribute : tag.attributes) {
    const bool link =
        attribute.name == "href" || attribute.name == "xlink:href";
    if (attribute.name.starts_with("on") ||
        (link && !attribute.value.starts_with('#'))) {
      return Malformed("<" + tag.name + "> has the attribute " +
                       attribute.name);
    }
  }
  return absl::OkStatus();
}

void PrefixIds(std::string_view prefix, Tag& tag) {
  for (auto& [name, value] : tag.attributes) {
    if (name == "id") {
      value.insert(0, prefix);
    } else if (name == "href" || name == "xlink:href") {
      value.insert(1, prefix);  // after #
    } else if (const auto at = value.find("url(#"); at != std::string::npos) {
      value.insert(at + 5, prefix);
    }
  }
}

std::string Pixels(double value) {
  return std::to_string(static_cast<long>(std::lround(value)));
}

absl::StatusOr<std::array<double, 4>> ParseViewBox(std::string_view text) {
  std::array<double, 4> box;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (double& number : box) {
    while (at < end && (IsSpace(*at) || *at == ',')) ++at;
    const auto parsed = std::from_chars(at, end, number);
    if (parsed.ec != std::errc()) return Malformed("its viewBox is broken");
    at = parsed.ptr;
  }
  const bool good = box[2] > 0.0 && box[2] < 1e5 && box[3] > 0.0;
  if (!good) return Malformed("its viewBox is empty or too large");
  return box;
}

// The <svg> tag with a size that follows the page's.
absl::Status MakeResponsive(std::string_view alt, Tag& root) {
  std::erase_if(root.attributes, [](const Attribute& attribute) {
    for (const std::string_view name :
         {"width", "height", "style", "role", "aria-label"}) {
      if (attribute.name == name) return true;
    }
    return false;
  });
  for (const Attribute& attribute : root.attributes) {
    if (attribute.name != "viewBox") continue;
    MLE_ASSIGN_OR_RETURN(const auto box, ParseViewBox(attribute.value));
    root.attributes.push_back(
        {"style", "max-width:" + Pixels(kLargestScale * box[2]) +
                      "px;min-width:" + Pixels(kSmallestScale * box[2]) +
                      "px"});
    root.attributes.push_back({"role", "img"});
    root.attributes.push_back({"aria-label", EscapeHtml(alt)});
    return absl::OkStatus();
  }
  return Malformed("it has no viewBox");
}

void AppendTag(const Tag& tag, std::string& out) {
  out += '<';
  out += tag.name;
  for (const auto& [name, value] : tag.attributes) {
    const char quote = value.find('"') == std::string::npos ? '"' : '\'';
    out += ' ';
    out += name;
    out += '=';
    out += quote;
    out += value;
    out += quote;
  }
  out += tag.closed ? "/>" : ">";
}

// Moves `at`, at a prolog, document type or comment, past it.
absl::Status SkipDeclaration(std::string_view svg, std::size_t& at) {
  const std::string_view end = svg.substr(at, 4) == "<!--" ? "-->" : ">";
  const std::size_t found = svg.find(end, at);
  if (found == std::string_view::npos) return Malformed("it ends early");
  at = found + end.size();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> EmbedSvg(std::string_view svg,
                                     std::string_view prefix,
                                     std::string_view alt) {
  std::string out;
  std::string skipped_until;  // the closing tag of a title or description
  bool has_root = false;
  bool ended = false;
  std::size_t at = 0;
  while (!ended) {
    const std::size_t open = svg.find('<', at);
    if (open == std::string_view::npos) return Malformed("it ends early");
    if (has_root && skipped_until.empty()) out += svg.substr(at, open - at);
    at = open;
    if (const char next = svg.substr(at).size() > 1 ? svg[at + 1] : ' ';
        next == '?' || next == '!') {
      MLE_RETURN_IF_ERROR(SkipDeclaration(svg, at));
      continue;
    }
    const std::size_t close = EndOfTag(svg, at);
    if (close == std::string_view::npos) return Malformed("a tag has no end");
    MLE_ASSIGN_OR_RETURN(Tag tag, ParseTag(svg.substr(at + 1, close - at - 1)));
    at = close + 1;
    if (!skipped_until.empty()) {
      if (tag.name == skipped_until) skipped_until.clear();
      continue;
    }
    if (tag.name == "title" || tag.name == "desc") {
      if (!tag.closed) skipped_until = "/" + tag.name;
      continue;
    }
    MLE_RETURN_IF_ERROR(CheckPassive(tag));
    if (!has_root) {
      if (tag.name != "svg") return Malformed("it opens with <" + tag.name);
      MLE_RETURN_IF_ERROR(MakeResponsive(alt, tag));
      has_root = true;
    }
    PrefixIds(prefix, tag);
    AppendTag(tag, out);
    ended = tag.name == "/svg";
  }
  return out + "\n";
}

}  // namespace mle::report
