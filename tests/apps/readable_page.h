// A page of a real run in a real browser, at the widths of telephones and
// screens, in light and dark mode: every figure is there, nothing is asked for
// from outside, no message on the console, nothing faint, cut or overlapping.

#ifndef TESTS_APPS_READABLE_PAGE_H_
#define TESTS_APPS_READABLE_PAGE_H_

#include <string>

namespace mle {

// What a page with a badge promises: screens of 900 pixels at 1440, and of 844
// pixels at 390, before a fold is opened; and how what its button copies
// begins, if it has one.
struct PagePromise {
  std::string badge = {};  // empty: no promise
  std::string copies = {};
  int least_folds = 4;
  double screens_at_1440 = 5.0;
  double screens_at_390 = 10.0;
};

// Expects all that of the page at `path`, with that many panels in its figures.
// Screenshots are called after `name`.
void ExpectReadable(const std::string& path, const std::string& name,
                    int panels, const PagePromise& promise = {});

// Expects that nothing of the page, folds opened, stands out of A4 where it is
// printed.
void ExpectFitsPaper(const std::string& path, const std::string& name);

}  // namespace mle

#endif  // TESTS_APPS_READABLE_PAGE_H_
