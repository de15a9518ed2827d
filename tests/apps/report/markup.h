// A small reader of XML, to check what is drawn and written.

#ifndef TESTS_APPS_REPORT_MARKUP_H_
#define TESTS_APPS_REPORT_MARKUP_H_

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace mle::report {

struct Element {
  std::string name;
  std::map<std::string, std::string> attributes;  // with entities resolved
  std::string text;  // what stands directly in it, entities resolved
};

struct Markup {
  std::vector<Element> elements;  // in the order they open
  std::string error;              // why it is not well formed; empty if it is

  std::vector<std::string> Values(std::string_view attribute) const;
  std::vector<std::string> Texts(std::string_view element) const;
  int Count(std::string_view element) const;
};

// Tags balanced, attributes quoted and unique, no bare < or &, no control
// characters, one root. Prologs and comments are skipped. With `html`, elements
// such as <meta> and <input> need no end, and <style> holds anything.
Markup ParseMarkup(std::string_view text, bool html = false);

}  // namespace mle::report

#endif  // TESTS_APPS_REPORT_MARKUP_H_
