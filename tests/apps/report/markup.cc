#include "tests/apps/report/markup.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <utility>

namespace mle::report {
namespace {

class Reader {
 public:
  Reader(std::string_view text, bool html) : text_(text), html_(html) {}

  Markup Read() {
    while (markup_.error.empty() && at_ < text_.size()) {
      if (text_[at_] == '<') {
        ReadMarkup();
      } else {
        ReadText();
      }
    }
    if (markup_.error.empty() && !open_.empty()) Fail("an element is open");
    if (markup_.error.empty() && roots_ != 1) Fail("there is not one root");
    return std::move(markup_);
  }

 private:
  void Fail(const std::string& what) {
    if (!markup_.error.empty()) return;
    markup_.error = what + " before: " + std::string(text_.substr(at_, 60));
  }

  std::string Resolved(std::string_view raw) {
    static const std::map<std::string, std::string, std::less<>> kEntities = {
        {"amp", "&"},   {"lt", "<"},  {"gt", ">"},
        {"quot", "\""}, {"#39", "'"}, {"apos", "'"}};
    std::string out;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const auto byte = static_cast<unsigned char>(raw[i]);
      if (byte < 0x20 && byte != '\n' && byte != '\t')
        Fail("control character");
      if (raw[i] == '<') Fail("bare <");
      if (raw[i] != '&') {
        out += raw[i];
        continue;
      }
      const std::size_t end = raw.find(';', i);
      const auto found = end == std::string_view::npos
                             ? kEntities.end()
                             : kEntities.find(raw.substr(i + 1, end - i - 1));
      if (found == kEntities.end()) {
        Fail("bare &");
        return out;
      }
      out += found->second;
      i = end;
    }
    return out;
  }

  void ReadText() {
    const std::size_t end = std::min(text_.find('<', at_), text_.size());
    const std::string text = Resolved(text_.substr(at_, end - at_));
    if (open_.empty()) {
      if (text.find_first_not_of(" \n\t") != std::string::npos) {
        Fail("text outside the root");
      }
    } else {
      markup_.elements[open_.back()].text += text;
    }
    at_ = end;
  }

  void SkipPast(std::string_view end) {
    const std::size_t found = text_.find(end, at_);
    if (found == std::string_view::npos) {
      Fail("no end");
    } else {
      at_ = found + end.size();
    }
  }

  std::string ReadName() {
    std::string name;
    while (at_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[at_])) ||
            text_[at_] == '-' || text_[at_] == ':' || text_[at_] == '_')) {
      name += text_[at_++];
    }
    if (name.empty()) Fail("a name is missing");
    return name;
  }

  void SkipSpace() {
    while (at_ < text_.size() &&
           std::isspace(static_cast<unsigned char>(text_[at_]))) {
      ++at_;
    }
  }

  void ReadMarkup() {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("<!--")) return SkipPast("-->");
    if (rest.starts_with("<?") || rest.starts_with("<!")) return SkipPast(">");
    ++at_;
    if (rest.starts_with("</")) {
      ++at_;
      const std::string name = ReadName();
      if (open_.empty() || markup_.elements[open_.back()].name != name) {
        return Fail("</" + name + "> closes nothing");
      }
      open_.pop_back();
      return SkipPast(">");
    }
    ReadElement();
  }

  void ReadElement() {
    Element element;
    element.name = ReadName();
    SkipSpace();
    while (at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/') {
      const std::string name = ReadName();
      SkipSpace();
      if (!text_.substr(at_).starts_with("=")) return Fail("no value");
      ++at_;
      SkipSpace();
      const char quote = at_ < text_.size() ? text_[at_] : ' ';
      if (quote != '"' && quote != '\'') return Fail("no quote");
      const std::size_t end = text_.find(quote, at_ + 1);
      if (end == std::string_view::npos) return Fail("no closing quote");
      const auto value = Resolved(text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
      if (!element.attributes.emplace(name, value).second) {
        return Fail(name + " twice");
      }
      SkipSpace();
    }
    if (open_.empty()) ++roots_;
    const bool closed = text_.substr(at_).starts_with("/>");
    const bool is_void =
        html_ && (element.name == "meta" || element.name == "input");
    const std::string name = element.name;
    const bool is_raw = html_ && (name == "style" || name == "script");
    SkipPast(">");
    markup_.elements.push_back(std::move(element));
    if (is_raw) return SkipPast("</" + name + ">");
    if (!closed && !is_void) open_.push_back(markup_.elements.size() - 1);
  }

  std::string_view text_;
  bool html_;
  std::size_t at_ = 0;
  int roots_ = 0;
  std::vector<std::size_t> open_;
  Markup markup_;
};

}  // namespace

std::vector<std::string> Markup::Values(std::string_view attribute) const {
  std::vector<std::string> values;
  for (const Element& element : elements) {
    const auto found = element.attributes.find(std::string(attribute));
    if (found != element.attributes.end()) values.push_back(found->second);
  }
  return values;
}

std::vector<std::string> Markup::Texts(std::string_view name) const {
  std::vector<std::string> texts;
  for (const Element& element : elements) {
    if (element.name == name) texts.push_back(element.text);
  }
  return texts;
}

int Markup::Count(std::string_view name) const {
  return static_cast<int>(Texts(name).size());
}

Markup ParseMarkup(std::string_view text, bool html) {
  return Reader(text, html).Read();
}

}  // namespace mle::report
