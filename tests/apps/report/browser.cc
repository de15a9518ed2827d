#include "tests/apps/report/browser.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

namespace fs = std::filesystem;

constexpr int kHeight = 1600;

std::string ReadAll(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// Paths of ours: nothing a shell would read otherwise. A browser that hangs
// before it has opened the page, as one did, is ended and started once more.
int Chromium(const std::string& arguments, const fs::path& out,
             const fs::path& log, const fs::path& profile) {
  const std::string command = absl::StrCat(
      "timeout 100 chromium-headless-shell --no-sandbox --disable-gpu "
      "--disable-dev-shm-usage --hide-scrollbars --enable-logging=stderr --v=0 "
      "--user-data-dir='",
      profile.string(), "' ", arguments, " >'", out.string(), "' 2>'",
      log.string(), "'");
  constexpr int kEndedByTimeout = 124;
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != kEndedByTimeout) {
    return status;
  }
  fs::remove_all(profile);
  return std::system(command.c_str());
}

std::vector<std::string> ConsoleOf(const fs::path& log) {
  std::vector<std::string> console;
  for (const auto& line : absl::StrSplit(ReadAll(log), '\n')) {
    if (line.find("CONSOLE") != std::string_view::npos) {
      console.emplace_back(line);
    }
  }
  return console;
}

// What page_check.js has left.
std::vector<std::string> ChecksOf(const std::string& dom) {
  const std::string open = "<pre id=\"check\" hidden=\"\">";
  std::vector<std::string> checks;
  for (std::size_t at = 0; (at = dom.find(open, at)) != std::string::npos;) {
    at += open.size();
    checks.push_back(
        absl::StrReplaceAll(dom.substr(at, dom.find("</pre>", at) - at),
                            {{"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}}));
  }
  return checks;
}

}  // namespace

bool HasBrowser() {
  return std::system("command -v chromium-headless-shell >/dev/null 2>&1") == 0;
}

std::vector<BrowserVisit> VisitPage(const std::string& html,
                                    const std::vector<int>& widths,
                                    const std::string& name, Mode mode) {
  std::vector<BrowserVisit> visits(widths.size());
  const auto failed = [&visits](const std::string& error) {
    for (BrowserVisit& visit : visits) visit.error = error;
    return visits;
  };
  const bool dark = mode == Mode::kDark;
  const std::string base = absl::StrCat(name, dark ? "_dark" : "");
  const fs::path folder = fs::current_path() / "screenshots";
  fs::create_directories(folder);
  const fs::path page = folder / (base + ".html");
  const fs::path dom = folder / (base + ".dom");
  const fs::path log = folder / (base + ".log");
  const fs::path profile = folder / (base + ".profile");
  std::string checked = html;
  const std::size_t end = checked.rfind("</body>");
  if (end == std::string::npos) return failed("the page has no </body>");
  checked.insert(end, "<script>" + ReadAll(MLE_PAGE_CHECK) + "</script>");
  // One visit for all widths, and for text and picture: most of what a visit
  // takes is the browser's start.
  const std::string framed = absl::StrCat(
      "<!DOCTYPE html><meta charset='utf-8'>"
      "<body style='margin:0;display:flex'>",
      absl::StrJoin(widths, "",
                    [&checked](std::string* out, int width) {
                      absl::StrAppend(out,
                                      "<iframe style='border:0;width:", width,
                                      "px;height:", kHeight, "px' srcdoc=\"",
                                      EscapeHtmlLines(checked), "\"></iframe>");
                    }),
      "</body>");
  const bool same_page = ReadAll(page) == framed;
  std::ofstream(page, std::ios::binary) << framed;
  const fs::path picture = folder / (base + ".png");
  const std::string earlier = ReadAll(picture);
  if (!earlier.empty() && !same_page) {
    fs::rename(picture, folder / (base + "_before.png"));
  }
  const int window = std::accumulate(widths.begin(), widths.end(), 0);
  if (Chromium(
          absl::StrCat("--virtual-time-budget=5000 ",
                       dark ? "--blink-settings=preferredColorScheme=0 " : "",
                       "--window-size=", window, ",", kHeight,
                       " --dump-dom --screenshot='", picture.string(),
                       "' 'file://", page.string(), "'"),
          dom, log, profile) != 0) {
    return failed("chromium failed: " + ReadAll(log));
  }
  const std::string text = ReadAll(dom);
  for (BrowserVisit& visit : visits) {
    visit.other_picture =
        !earlier.empty() && same_page && ReadAll(picture) != earlier;
    visit.console = ConsoleOf(log);
    visit.error = "the check did not finish: " + ReadAll(log);
  }
  // Frames finish in any order, and say how wide they are.
  for (const std::string& json : ChecksOf(text)) {
    const auto found = nlohmann::json::parse(json, nullptr, false);
    if (found.is_discarded()) return failed("no JSON: " + json);
    const auto at = std::find(widths.begin(), widths.end(), found["width"]);
    if (at == widths.end()) return failed("another width: " + json);
    BrowserVisit& visit = visits[at - widths.begin()];
    visit.found = found;
    visit.error.clear();
  }
  fs::remove_all(profile);
  fs::remove(dom);
  return visits;
}

BrowserVisit LoadUrl(const std::string& url, const std::string& name) {
  BrowserVisit visit;
  const fs::path folder = fs::current_path() / "screenshots";
  fs::create_directories(folder);
  const fs::path dom = folder / (name + ".dom");
  const fs::path log = folder / (name + ".log");
  const fs::path profile = folder / (name + ".profile");
  if (Chromium("--virtual-time-budget=5000 --dump-dom '" + url + "'", dom, log,
               profile) != 0) {
    visit.error = "chromium failed: " + ReadAll(log);
  }
  visit.console = ConsoleOf(log);
  visit.found["dom"] = ReadAll(dom);
  fs::remove_all(profile);
  return visit;
}

}  // namespace mle::report
