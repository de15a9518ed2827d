// A report as one HTML page that needs nothing but itself: no network, no other
// files. Without scripts it is whole; one script shows the values of a figure's
// curves under the pointer (page_style.h), a button copies a table, others sort
// and filter one (table.h).
//
// It reads well from telephone to wide screen, in light and dark mode, and on
// A4. All text is escaped; there is no way to put markup in.
//
//   HtmlPage page("Model correction");
//   page.SetVerdict({Badge::kGood, "unchanged", "The model still holds",
//                    {"Keep it."}});
//   page.AddSummary({"The error fell from 19,363 to 8.1."});
//   page.AddHeading("Choice of λ");
//   page.AddFigure(figure, "Error over λ.",
//                  "Two curves with a minimum near 1e-5.");
//   page.AddTable(table);
//   page.AddRunAgain({.command = QuoteCommandLine(arguments)});
//   WriteFileAtomically(path, page.Render());

#ifndef APPS_REPORT_HTML_H_
#define APPS_REPORT_HTML_H_

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/report/figure.h"
#include "apps/report/table.h"

namespace mle::report {

// A form that a server takes by POST; of no use in a page that is a file.
struct Form {
  std::string action = {};  // path on the server that the page came from
  std::string submit = {};  // on the button
  struct Field {
    std::string name = {};
    std::string label = {};
    enum class Kind { kText, kPassword, kHidden };
    Kind kind = Kind::kText;
    std::string value = {};
    std::string autocomplete = "off";  // as HTML has it: "username"
    int most_characters = 200;
    bool required = false;
  };
  std::vector<Field> fields = {};
};

// The data needed to make the same report once more. Empty fields are left out.
struct RunAgain {
  std::string command = {};  // as typed into a shell; see QuoteCommandLine
  std::string version = {};
  std::string seeds = {};
  std::vector<std::pair<std::string, std::string>> more = {};  // name, value
};

// The colour of a badge; its words say the same.
enum class Badge { kGood, kChanged, kUnknown };

// The verdict that a page begins with.
struct Verdict {
  Badge badge = Badge::kUnknown;
  std::string label = {};  // in the badge: "corrected"
  std::string headline = {};
  std::vector<std::string> sentences = {};

  // Headline and sentences, a line each.
  std::string Text() const;
};

class HtmlPage {
 public:
  explicit HtmlPage(std::string title);

  // In place of the title as the heading of the page.
  void SetVerdict(Verdict verdict) { verdict_ = std::move(verdict); }

  // The findings in a few sentences, set apart from the rest.
  void AddSummary(const std::vector<std::string>& sentences);
  // A section; from three on, the page opens with a table of contents.
  void AddHeading(std::string_view text);
  void AddSubheading(std::string_view text);
  void AddParagraph(std::string_view text);  // nothing where it is empty
  void AddList(const std::vector<std::string>& items);
  // Terms with what they mean, side by side where there is room.
  void AddTerms(const std::vector<std::pair<std::string, std::string>>& terms);
  void AddWarning(std::string_view text);
  // In a fold where there are more than three.
  void AddWarnings(const std::vector<std::string>& texts);
  // Content that follows, until the fold is closed, is shown when a reader
  // opens it.
  void OpenFold(std::string_view title);
  void CloseFold();
  void AddTable(const Table& table);
  // With a button that copies header and cells of `copied`, separated by tabs.
  void AddTableToCopy(const Table& shown, const Table& copied);
  // `alt` says in words what is to be seen. A figure that cannot be drawn
  // leaves a warning with the reason. One outside folds has its panels below
  // each other on a narrow page. Figures are numbered from 1, those outside
  // folds first.
  void AddFigure(const Figure& figure, std::string_view caption,
                 std::string_view alt);
  void AddCode(std::string_view code);
  void AddForm(const Form& form);
  // Links to files beside the page: name shown, path relative to the page.
  void AddFiles(const std::vector<std::pair<std::string, std::string>>& files);
  // With a heading, unless a fold is open.
  void AddRunAgain(const RunAgain& run);
  // The folds at the end of a page: its files, if any, and AddRunAgain().
  void AddLastFolds(
      const std::vector<std::pair<std::string, std::string>>& files,
      const RunAgain& run);

  std::string Render() const;

 private:
  std::string title_;
  std::optional<Verdict> verdict_;
  std::string body_;
  std::vector<std::string> headings_;
  int open_folds_ = 0;
  std::vector<bool> folded_;  // of each figure, whether in a fold
  int tables_ = 0;
};

// All scripts that pages hold, to the byte: a server can allow these and no
// others.
std::vector<std::string_view> PageScripts();

}  // namespace mle::report

#endif  // APPS_REPORT_HTML_H_
