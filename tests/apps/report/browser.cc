#include "tests/apps/report/browser.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

namespace fs = std::filesystem;

// Windows are at least so wide; a narrower page stands in a frame.
constexpr int kNarrowest = 500;

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
      "timeout 100 chromium --headless --no-sandbox --disable-gpu "
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

}  // namespace

bool HasBrowser() {
  return std::system("command -v chromium >/dev/null 2>&1") == 0;
}

BrowserVisit VisitPage(const std::string& html, int width,
                       const std::string& name, Mode mode) {
  BrowserVisit visit;
  const bool dark = mode == Mode::kDark;
  const std::string base = absl::StrCat(name, "_", width, dark ? "_dark" : "");
  const fs::path folder = fs::current_path() / "screenshots";
  fs::create_directories(folder);
  const fs::path page = folder / (base + ".html");
  const fs::path dom = folder / (base + ".dom");
  const fs::path log = folder / (base + ".log");
  const fs::path profile = folder / (base + ".profile");
  std::string checked = html;
  const std::size_t end = checked.rfind("</body>");
  if (end == std::string::npos) {
    visit.error = "the page has no </body>";
    return visit;
  }
  checked.insert(end, "<script>" + ReadAll(MLE_PAGE_CHECK) + "</script>");
  if (width < kNarrowest) {
    checked = absl::StrCat(
        "<!DOCTYPE html><body style='margin:0'><iframe style='border:0;width:",
        width, "px;height:1500px' srcdoc=\"", EscapeHtmlLines(checked),
        "\"></iframe></body>");
  }
  const bool same_page = ReadAll(page) == checked;
  std::ofstream(page, std::ios::binary) << checked;
  const fs::path picture = folder / (base + ".png");
  const std::string earlier = ReadAll(picture);
  if (!earlier.empty() && !same_page) {
    fs::rename(picture, folder / (base + "_before.png"));
  }
  // Text and picture in one visit: most of what one takes is the browser's
  // start.
  if (Chromium(absl::StrCat(
                   "--virtual-time-budget=5000 ",
                   dark ? "--blink-settings=preferredColorScheme=0 " : "",
                   "--window-size=", width, ",1600 --dump-dom --screenshot='",
                   picture.string(), "' 'file://", page.string(), "'"),
               dom, log, profile) != 0) {
    visit.error = "chromium failed: " + ReadAll(log);
    return visit;
  }
  visit.other_picture =
      !earlier.empty() && same_page && ReadAll(picture) != earlier;
  visit.console = ConsoleOf(log);
  const std::string text = ReadAll(dom);
  const std::string open = "<pre id=\"check\" hidden=\"\">";
  const std::size_t start = text.rfind(open);
  if (start == std::string::npos) {
    visit.error = "the check did not finish: " + ReadAll(log);
    return visit;
  }
  std::string json = text.substr(start + open.size());
  json = json.substr(0, json.find("</pre>"));
  for (const auto& [entity, character] :
       {std::pair<std::string, std::string>{"&lt;", "<"},
        {"&gt;", ">"},
        {"&amp;", "&"}}) {
    for (std::size_t at = 0; (at = json.find(entity, at)) != std::string::npos;
         ++at) {
      json.replace(at, entity.size(), character);
    }
  }
  visit.found = nlohmann::json::parse(json, nullptr, false);
  if (visit.found.is_discarded()) visit.error = "no JSON: " + json;
  fs::remove_all(profile);
  fs::remove(dom);
  return visit;
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
