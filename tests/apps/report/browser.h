// Opens a page in headless Chromium and looks at it (page_check.js).

#ifndef TESTS_APPS_REPORT_BROWSER_H_
#define TESTS_APPS_REPORT_BROWSER_H_

#include <string>
#include <vector>

#include "nlohmann/json.hpp"

namespace mle::report {

struct BrowserVisit {
  std::string error;                 // empty, or why there is nothing more
  nlohmann::json found;              // by page_check.js
  std::vector<std::string> console;  // messages, errors among them
  // An earlier run of the tests took another picture of the same page.
  bool other_picture = false;
};

// Whether there is a Chromium to test with.
bool HasBrowser();

enum class Mode { kLight, kDark };

// `html` in a frame of each of `widths` pixels: a visit for each, in their
// order. A screenshot of all is kept as screenshots/NAME.png (or NAME_dark.png)
// in the folder the test runs in. That of an earlier run is compared with it
// where the page is the same; where the page has changed it is kept as
// …_before.png, to be looked at.
std::vector<BrowserVisit> VisitPage(const std::string& html,
                                    const std::vector<int>& widths,
                                    const std::string& name,
                                    Mode mode = Mode::kLight);

// What a server shows, as it comes: "dom" in `found` is the document after its
// scripts, of which `console` has the complaints.
BrowserVisit LoadUrl(const std::string& url, const std::string& name);

}  // namespace mle::report

#endif  // TESTS_APPS_REPORT_BROWSER_H_
