#include "apps/report/html.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/report/page_style.h"
#include "apps/report/svg.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// Hides the rows that do not hold the text, in any case of letters, or have
// another value in the column of the list, and says how many are left.
constexpr std::string_view kFilter =
    "const q=this.querySelector('input').value.trim().toLowerCase(),c=this."
    "querySelector('select'),b=this.querySelector('table').tBodies[0];let n=0;"
    "for(const r of b.rows){r.hidden=!(r.textContent.toLowerCase().includes(q)"
    "&&(!c||!c.value||r.cells[+c.dataset.column].textContent===c.value));"
    "n+=!r.hidden}this.querySelector('output').textContent=n.toLocaleString("
    "'en')+' of '+b.rows.length.toLocaleString('en')";

// The values of the column.
std::set<std::string> ValuesOf(const Table& table, std::size_t column) {
  std::set<std::string> values;
  for (const auto& row : table.rows) {
    if (column < row.size()) values.insert(row[column]);
  }
  return values;
}

std::string RenderChoice(const Table& table) {
  if (table.choice < 0 ||
      static_cast<std::size_t>(table.choice) >= table.columns.size()) {
    return "";
  }
  const auto column = static_cast<std::size_t>(table.choice);
  std::string out = "<label>" + EscapeHtml(table.columns[column].header) +
                    " <select data-column=\"" + std::to_string(column) +
                    "\"><option value=\"\">all</option>";
  for (const std::string& value : ValuesOf(table, column)) {
    out += "<option>" + EscapeHtml(value) + "</option>";
  }
  return out + "</select></label>\n";
}

std::string_view TypeOf(Form::Field::Kind kind) {
  constexpr std::string_view kTypes[] = {"text", "password", "hidden"};
  return kTypes[static_cast<int>(kind)];
}

std::string RenderField(const Form::Field& field) {
  std::string input = "<input type=\"";
  input += TypeOf(field.kind);
  input += "\" name=\"" + EscapeHtml(field.name) + "\"";
  if (!field.value.empty()) {
    input += " value=\"" + EscapeHtml(field.value) + "\"";
  }
  if (field.kind == Form::Field::Kind::kHidden) return input + ">\n";
  input += " autocomplete=\"" + EscapeHtml(field.autocomplete) + "\"";
  input += " maxlength=\"" + std::to_string(field.most_characters) + "\"";
  if (field.required) input += " required=\"required\"";
  return "<label>" + EscapeHtml(field.label) + " " + input + "></label>\n";
}

std::string RenderForm(const Form& form) {
  std::string out =
      "<form method=\"post\" action=\"" + EscapeHtml(form.action) + "\">\n";
  for (const Form::Field& field : form.fields) out += RenderField(field);
  return out + "<button type=\"submit\">" + EscapeHtml(form.submit) +
         "</button>\n</form>\n";
}

// `content`, which holds the table, below the fields that filter it. Without
// scripts the fields are not shown.
std::string RenderFilter(const Table& table, std::string_view content) {
  std::string out = "<div class=\"filtered\" oninput=\"";
  out += EscapeHtml(kFilter) + "\">\n<div class=\"filter\">\n";
  out += "<label>Search <input type=\"search\"></label>\n";
  out += RenderChoice(table);
  const std::string rows =
      FormatInteger(static_cast<std::int64_t>(table.rows.size()));
  out += "<output>" + rows + " of " + rows + "</output>\n</div>\n";
  out += content;
  return out + "</div>\n";
}

bool IsOfFlag(char c) {
  return absl::ascii_islower(static_cast<unsigned char>(c)) ||
         absl::ascii_isdigit(static_cast<unsigned char>(c)) || c == '_';
}

// Text of sentences, escaped, in which the name of a flag ("--data") is not
// broken after its hyphens at the end of a line.
std::string Prose(std::string_view text) {
  const std::string escaped = EscapeHtml(WithSignsKept(text));
  std::string out;
  std::size_t at = 0;
  for (std::size_t begin = escaped.find("--"); begin != std::string::npos;
       begin = escaped.find("--", at)) {
    std::size_t end = begin + 2;
    while (end < escaped.size() && IsOfFlag(escaped[end])) ++end;
    out += escaped.substr(at, begin - at);
    const std::string name = escaped.substr(begin, end - begin);
    out += name.size() > 2 ? "<span class=\"flag\">" + name + "</span>" : name;
    at = end;
  }
  return out + escaped.substr(at);
}

// A box that scrolls sideways by itself where it is wider than the page; it
// can be reached by keyboard.
std::string Scrolling(std::string_view css_class, std::string_view name,
                      std::string_view content) {
  std::string out = "<div class=\"scroll ";
  out += css_class;
  out += "\" tabindex=\"0\" role=\"region\" aria-label=\"";
  out += EscapeHtml(name) + "\">\n";
  out += content;
  return out + "</div>\n";
}

// Copies data-text; where a browser does not let it, the table is selected for
// the reader to copy.
constexpr std::string_view kCopy =
    "const b=this,say=t=>{b.textContent=t};(navigator.clipboard?"
    "navigator.clipboard.writeText(b.dataset.text):Promise.reject()).then("
    "()=>say('Copied'),()=>{getSelection().selectAllChildren("
    "b.parentElement.querySelector('table'));"
    "say(document.execCommand('copy')?'Copied':'Selected: press Ctrl+C')})";

std::string_view BadgeName(Badge badge) {
  constexpr std::string_view kNames[] = {"good", "changed", "unknown"};
  return kNames[static_cast<int>(badge)];
}

std::string RenderVerdict(const Verdict& verdict, const std::string& title) {
  std::string out = "<header class=\"verdict ";
  out += BadgeName(verdict.badge);
  out += "\">\n<p class=\"title\">" + title +
         "</p>\n<h1><span class=\"badge\">" + EscapeHtml(verdict.label) +
         "</span> " + EscapeHtml(WithSignsKept(verdict.headline)) + "</h1>\n";
  for (const std::string& sentence : verdict.sentences) {
    out += "<p>" + Prose(sentence) + "</p>\n";
  }
  return out + "</header>\n";
}

std::string Warning(const std::string& markup) {
  return "<div class=\"warning\" "
         "role=\"note\">\n<p><strong>Warning:</strong> " +
         markup + "</p>\n</div>\n";
}

// Stands for the number of a figure until all are known: text has no control
// characters.
std::string NumberMark(std::size_t figure) {
  return absl::StrCat("\x1A", figure, "\x1A");
}

std::string WithNumbers(std::string text, const std::vector<bool>& folded) {
  int number = 0;
  for (const bool in_fold : {false, true}) {
    for (std::size_t f = 0; f < folded.size(); ++f) {
      if (folded[f] != in_fold) continue;
      absl::StrReplaceAll({{NumberMark(f), absl::StrCat(++number)}}, &text);
    }
  }
  return text;
}

// The width of a telephone.
constexpr double kNarrowCm = 9.0;

// Squares with labels cannot be narrower.
bool IsTooWide(const Figure& figure) {
  return figure.width_cm > kNarrowCm &&
         std::none_of(figure.panels.begin(), figure.panels.end(),
                      [](const Panel& panel) { return !panel.cells.empty(); });
}

Figure InOneColumn(Figure figure) {
  constexpr double kPanelCm = 5.2;
  constexpr double kAroundCm = 1.5;
  const auto panels = static_cast<double>(figure.panels.size());
  figure.columns = 1;
  figure.width_cm = kNarrowCm;
  figure.height_cm = kAroundCm + kPanelCm * panels;
  // Only the last row of several columns has one.
  for (Panel& panel : figure.panels) {
    if (panel.x.label.empty()) panel.x.label = figure.panels.back().x.label;
  }
  return figure;
}

}  // namespace

std::string Verdict::Text() const {
  std::string text = headline + ".\n";
  for (const std::string& sentence : sentences) text += sentence + "\n";
  return text;
}

HtmlPage::HtmlPage(std::string title) : title_(std::move(title)) {}

void HtmlPage::AddSummary(const std::vector<std::string>& sentences) {
  body_ += "<div class=\"summary\">\n";
  for (const std::string& sentence : sentences) AddParagraph(sentence);
  body_ += "</div>\n";
}

void HtmlPage::AddHeading(std::string_view text) {
  headings_.emplace_back(text);
  body_ += "<h2 id=\"section-" + std::to_string(headings_.size()) + "\">" +
           EscapeHtml(text) + "</h2>\n";
}

void HtmlPage::AddSubheading(std::string_view text) {
  body_ += "<h3>" + EscapeHtml(text) + "</h3>\n";
}

void HtmlPage::AddParagraph(std::string_view text) {
  if (text.empty()) return;
  body_ += "<p>" + Prose(text) + "</p>\n";
}

void HtmlPage::AddList(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) {
    body_ += "<li>" + Prose(item) + "</li>\n";
  }
  body_ += "</ul>\n";
}

void HtmlPage::AddTerms(
    const std::vector<std::pair<std::string, std::string>>& terms) {
  if (terms.empty()) return;
  body_ += "<dl>\n";
  for (const auto& [term, meaning] : terms) {
    body_ +=
        "<dt>" + EscapeHtml(term) + "</dt><dd>" + Prose(meaning) + "</dd>\n";
  }
  body_ += "</dl>\n";
}

void HtmlPage::AddWarning(std::string_view text) {
  body_ += Warning(Prose(text));
}

void HtmlPage::AddWarnings(const std::vector<std::string>& texts) {
  constexpr std::size_t kMostOpen = 3;
  const bool many = texts.size() > kMostOpen;
  if (many) OpenFold(std::to_string(texts.size()) + " warnings");
  for (const std::string& text : texts) AddWarning(text);
  if (many) CloseFold();
}

void HtmlPage::OpenFold(std::string_view title) {
  ++open_folds_;
  body_ += "<details>\n<summary>" + EscapeHtml(title) + "</summary>\n";
}

void HtmlPage::CloseFold() {
  --open_folds_;
  body_ += "</details>\n";
}

void HtmlPage::AddTable(const Table& table) {
  const std::string name = table.caption.empty()
                               ? "Table " + std::to_string(++tables_)
                               : table.caption;
  const std::string shown = Scrolling("table", name, RenderHtml(table));
  if (table.searchable) {
    body_ += RenderFilter(table, shown);
  } else if (table.stacked) {
    body_ += "<div class=\"stacked\">\n" + shown + "</div>\n";
  } else {
    body_ += shown;
  }
}

void HtmlPage::AddTableToCopy(const Table& shown, const Table& copied) {
  body_ +=
      "<div class=\"copied\">\n<button type=\"button\" class=\"copy\" "
      "data-text=\"";
  body_ += EscapeHtmlLines(RenderTabbed(copied)) + "\" onclick=\"";
  body_ += kCopy;
  body_ += "\">Copy the table</button>\n";
  AddTable(shown);
  body_ += "</div>\n";
}

void HtmlPage::AddFigure(const Figure& figure, std::string_view caption,
                         std::string_view alt) {
  const std::string number = NumberMark(folded_.size());
  folded_.push_back(open_folds_ > 0);
  const absl::StatusOr<std::string> picture = SvgElement(figure, alt);
  if (!picture.ok()) {
    body_ += Warning("Figure " + number +
                     Prose(" (" + std::string(caption) + ") is missing: " +
                           std::string(picture.status().message())));
    return;
  }
  absl::StatusOr<std::string> narrow = absl::NotFoundError("");
  if (open_folds_ == 0 && IsTooWide(figure)) {
    narrow = SvgElement(InOneColumn(figure), alt);
  }
  const std::string label = "Figure " + number;
  body_ += "<figure>\n";
  body_ += narrow.ok() ? Scrolling("picture wide", label, *picture) +
                             Scrolling("picture narrow", label, *narrow)
                       : Scrolling("picture", label, *picture);
  body_ += "<figcaption>" + label + ". " + Prose(caption) +
           "</figcaption>\n</figure>\n";
}

void HtmlPage::AddCode(std::string_view code) {
  body_ += "<pre><code>" + EscapeHtmlLines(code) + "</code></pre>\n";
}

void HtmlPage::AddForm(const Form& form) { body_ += RenderForm(form); }

void HtmlPage::AddFiles(
    const std::vector<std::pair<std::string, std::string>>& files) {
  body_ += "<ul>\n";
  for (const auto& [name, path] : files) {
    body_ += "<li><a href=\"" + RelativeUrl(path) + "\">" + EscapeHtml(name) +
             "</a></li>\n";
  }
  body_ += "</ul>\n";
}

void HtmlPage::AddLastFolds(
    const std::vector<std::pair<std::string, std::string>>& files,
    const RunAgain& run) {
  if (!files.empty()) {
    OpenFold("Files");
    AddFiles(files);
    CloseFold();
  }
  OpenFold("Run it again");
  AddRunAgain(run);
  CloseFold();
}

void HtmlPage::AddRunAgain(const RunAgain& run) {
  if (open_folds_ == 0) AddHeading("Run it again");
  if (!run.command.empty()) AddCode(run.command);
  std::vector<std::pair<std::string, std::string>> terms = {
      {"Version", run.version}, {"Seeds", run.seeds}};
  terms.insert(terms.end(), run.more.begin(), run.more.end());
  std::erase_if(terms, [](const auto& term) { return term.second.empty(); });
  AddTerms(terms);
}

std::string HtmlPage::Render() const {
  const std::string title = EscapeHtml(title_);
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<title>";
  out += title + "</title>\n<style>";
  out += PageStyle();
  if (!folded_.empty()) out += FigureStyle();
  out += "</style>\n</head>\n<body>\n<main>\n";
  out += verdict_.has_value() ? RenderVerdict(*verdict_, title)
                              : "<h1>" + title + "</h1>\n";
  if (headings_.size() >= 3) {
    out += "<nav aria-label=\"Contents\">\n<ul>\n";
    for (std::size_t i = 0; i < headings_.size(); ++i) {
      out += "<li><a href=\"#section-" + std::to_string(i + 1) + "\">" +
             EscapeHtml(headings_[i]) + "</a></li>\n";
    }
    out += "</ul>\n</nav>\n";
  }
  out += WithNumbers(body_, folded_) + "</main>\n";
  if (!folded_.empty()) {
    out += "<script>";
    out += ReadoutScript();
    out += "</script>\n";
  }
  return out + "</body>\n</html>\n";
}

std::vector<std::string_view> PageScripts() {
  return {kCopy, SortScript(), kFilter, ReadoutScript()};
}

}  // namespace mle::report
