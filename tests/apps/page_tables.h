// What a page shows, read back: its tables.

#ifndef TESTS_APPS_PAGE_TABLES_H_
#define TESTS_APPS_PAGE_TABLES_H_

#include <string>
#include <vector>

namespace mle {

struct PageTable {
  std::string caption;
  std::vector<std::vector<std::string>> rows;  // the header first
};

std::vector<PageTable> TablesOf(const std::string& html);

// The first table whose caption begins so; a failure of the test if there is
// none.
PageTable TableOf(const std::string& html, const std::string& caption);

// Fails unless `text` begins with `value` as a person would write it: every
// digit shown is right. Thousands may be grouped; "−1.2×10⁻¹¹" is a number.
void ExpectShows(const std::string& text, double value);

}  // namespace mle

#endif  // TESTS_APPS_PAGE_TABLES_H_
