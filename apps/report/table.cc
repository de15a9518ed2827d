#include "apps/report/table.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/strings/str_replace.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// The table with all rows of the same length.
Table Squared(Table table) {
  std::size_t width = table.columns.size();
  for (const auto& row : table.rows) width = std::max(width, row.size());
  table.columns.resize(width);
  for (auto& row : table.rows) row.resize(width);
  return table;
}

std::string Padded(const std::string& text, int width, Align align) {
  const int blanks = std::max(0, width - DisplayWidth(text));
  const int left = align == Align::kLeft     ? 0
                   : align == Align::kCenter ? blanks / 2
                                             : blanks;
  return std::string(left, ' ') + text + std::string(blanks - left, ' ');
}

void AddLine(std::string line, std::string& out) {
  line.erase(line.find_last_not_of(' ') + 1);
  out += line + '\n';
}

std::string_view ClassOf(Align align) {
  constexpr std::string_view kClasses[] = {"left", "center", "right"};
  return kClasses[static_cast<int>(align)];
}

// "2024-03-04", with a time of day or without; not followed by words.
bool IsDate(std::string_view text) {
  constexpr std::string_view kForm = "dddd-dd-dd";
  constexpr std::size_t kLongest = 26;  // 2024-03-04 06:00:30+00:00
  if (text.size() < kForm.size() || text.size() > kLongest) return false;
  for (std::size_t k = 0; k < kForm.size(); ++k) {
    const bool digit = text[k] >= '0' && text[k] <= '9';
    if (kForm[k] == 'd' ? !digit : text[k] != '-') return false;
  }
  return true;
}

// `content` is markup.
// `label`: of its column, where a narrow page shows it.
void AddHtmlCell(std::string_view tag, std::string_view scope, Align align,
                 int level, std::string_view content, std::string& out,
                 std::string_view label = "") {
  out += "<";
  out += tag;
  if (!scope.empty()) {
    out += " scope=\"";
    out += scope;
    out += "\"";
  }
  out += " class=\"";
  out += ClassOf(align);
  if (level > 0) out += " level-" + std::to_string(level);
  if (IsDate(content)) out += " date";
  out += "\"";
  if (!label.empty()) out += " data-label=\"" + EscapeHtml(label) + "\"";
  out += ">";
  out += content;
  out += "</";
  out += tag;
  out += ">";
}

int LevelOf(const Table& table, std::size_t row, std::size_t column) {
  if (row >= table.levels.size() || column >= table.levels[row].size()) {
    return 0;
  }
  return std::clamp(table.levels[row][column], 0, kTableLevels);
}

// That of all cells of a row; 0 where they differ.
int CommonLevel(const Table& table, std::size_t row) {
  const int first = LevelOf(table, row, 0);
  for (std::size_t j = 1; j < table.columns.size(); ++j) {
    if (LevelOf(table, row, j) != first) return 0;
  }
  return first;
}

// The rows in the order of the column, then the other way round; numbers, with
// minus signs and signs of percent, before words.
constexpr std::string_view kSort =
    "const h=this.closest('th'),t=h.closest('table'),b=t.tBodies[0],i=h."
    "cellIndex,s=h.getAttribute('aria-sort')==='ascending'?-1:1,v=r=>{const "
    "x=r.cells[i].textContent.trim().replace(/\u2212/g,'-').replace(/,/g,'');"
    "return/^-?[\\d.]+( ?%)?$/.test(x)?parseFloat(x):x};t.querySelectorAll("
    "'th[aria-sort]').forEach(o=>o.removeAttribute('aria-sort'));h."
    "setAttribute('aria-sort',s>0?'ascending':'descending');[...b.rows].sort(("
    "p,q)=>{const x=v(p),y=v(q),n=typeof x==='number',m=typeof y==='number';"
    "return s*(n&&m?x-y:n!==m?(n?-1:1):x<y?-1:x>y?1:0)}).forEach(r=>b.append("
    "r))";

std::string SortButton(const std::string& header) {
  std::string out = "<button type=\"button\" class=\"sort\" onclick=\"";
  out += EscapeHtml(kSort) + "\">" + EscapeHtml(header) + "</button>";
  return out;
}

std::string Linked(const Table& table, std::size_t row,
                   const std::string& text) {
  if (row >= table.links.size() || table.links[row].empty()) {
    return EscapeHtml(text);
  }
  return "<a href=\"" + RelativeUrl(table.links[row]) + "\">" +
         EscapeHtml(text) + "</a>";
}

void AddTabbedLine(const std::vector<std::string>& cells, std::string& out) {
  for (std::size_t j = 0; j < cells.size(); ++j) {
    if (j > 0) out += '\t';
    out += absl::StrReplaceAll(CleanText(cells[j]), {{"−", "-"}});
  }
  out += '\n';
}

}  // namespace

void Table::AddRow(std::vector<std::string> cells) {
  rows.push_back(std::move(cells));
}

std::string RenderText(const Table& table) {
  Table square = Squared(table);
  std::vector<int> widths;
  for (std::size_t j = 0; j < square.columns.size(); ++j) {
    square.columns[j].header = CleanText(square.columns[j].header);
    int width = DisplayWidth(square.columns[j].header);
    for (auto& row : square.rows) {
      row[j] = CleanText(row[j]);
      width = std::max(width, DisplayWidth(row[j]));
    }
    widths.push_back(width);
  }

  std::string out;
  if (!square.caption.empty()) AddLine(CleanText(square.caption), out);
  std::string header;
  std::string rule;
  for (std::size_t j = 0; j < square.columns.size(); ++j) {
    const std::string_view gap = j == 0 ? "" : "  ";
    const Column& column = square.columns[j];
    header += gap;
    header += Padded(column.header, widths[j], column.align);
    rule += gap;
    for (int i = 0; i < widths[j]; ++i) rule += "─";
  }
  AddLine(header, out);
  AddLine(rule, out);
  for (const auto& row : square.rows) {
    std::string line;
    for (std::size_t j = 0; j < row.size(); ++j) {
      line += j == 0 ? "" : "  ";
      line += Padded(row[j], widths[j], square.columns[j].align);
    }
    AddLine(line, out);
  }
  return out;
}

std::string RenderTabbed(const Table& table) {
  const Table square = Squared(table);
  std::vector<std::string> header;
  for (const Column& column : square.columns) header.push_back(column.header);
  std::string out;
  AddTabbedLine(header, out);
  for (const auto& row : square.rows) AddTabbedLine(row, out);
  return out;
}

std::string_view SortScript() { return kSort; }

std::string RenderHtml(const Table& table) {
  const Table square = Squared(table);
  std::string out = "<table>\n";
  if (!square.caption.empty()) {
    out += "<caption>" + EscapeHtml(WithSignsKept(square.caption)) +
           "</caption>\n";
  }
  out += "<thead>\n<tr>";
  for (const Column& column : square.columns) {
    AddHtmlCell(column.header.empty() ? "td" : "th",
                column.header.empty() ? "" : "col", column.align, 0,
                square.sortable && !column.header.empty()
                    ? SortButton(column.header)
                    : EscapeHtml(column.header),
                out);
  }
  out += "</tr>\n</thead>\n<tbody>\n";
  for (std::size_t i = 0; i < square.rows.size(); ++i) {
    const auto& row = square.rows[i];
    const int level = CommonLevel(square, i);
    out += level > 0 ? "<tr class=\"level-" + std::to_string(level) + "\">"
                     : std::string("<tr>");
    for (std::size_t j = 0; j < row.size(); ++j) {
      const bool names_row = j == 0 && square.row_headers;
      AddHtmlCell(names_row ? "th" : "td", names_row ? "row" : "",
                  square.columns[j].align,
                  level > 0 ? 0 : LevelOf(square, i, j),
                  j == 0 ? Linked(square, i, row[j]) : EscapeHtml(row[j]), out,
                  (square.searchable || square.stacked) && !names_row
                      ? square.columns[j].header
                      : std::string());
    }
    out += "</tr>\n";
  }
  return out + "</tbody>\n</table>\n";
}

}  // namespace mle::report
