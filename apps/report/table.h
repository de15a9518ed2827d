// A table of strings, shown as aligned text on a terminal and as HTML.
//
//   Table table{.caption = "Error E by case",
//               .columns = {{"case", Align::kLeft}, {"E"}}};
//   table.AddRow({"gain", FormatSignificant(8.13)});
//   std::cout << RenderText(table);

#ifndef APPS_REPORT_TABLE_H_
#define APPS_REPORT_TABLE_H_

#include <string>
#include <string_view>
#include <vector>

namespace mle::report {

inline constexpr int kTableLevels = 4;

enum class Align { kLeft, kCenter, kRight };

struct Column {
  std::string header = {};
  Align align = Align::kRight;
};

struct Table {
  std::string caption = {};
  std::vector<Column> columns = {};
  // A short row is filled up with empty cells; cells beyond the last column
  // are shown under an empty header.
  std::vector<std::vector<std::string>> rows = {};
  // The first cell of a row names the row (in HTML: <th scope="row">).
  bool row_headers = true;
  // In HTML, how strongly the ground of each cell is coloured: from 0, not at
  // all, to kTableLevels. Missing ones are 0.
  std::vector<std::vector<int>> levels = {};
  // In HTML, where the first cell of each row leads, beside the page; missing
  // or empty: nowhere.
  std::vector<std::string> links = {};
  // In HTML, headers are buttons that sort the rows, numbers by value.
  bool sortable = false;
  // In a page, a field above the table leaves the rows that hold its text, and
  // a list those with one value of the column `choice` (−1: no list). On a
  // narrow page the cells of a row stand one below the other.
  bool searchable = false;
  int choice = -1;
  // On a narrow page the cells of a row stand one below the other, each with
  // its header; of searchable tables always.
  bool stacked = false;

  void AddRow(std::vector<std::string> cells);
};

// Caption, header, a rule and the rows, each line ending in a newline and
// without trailing blanks; columns are two blanks apart.
std::string RenderText(const Table& table);

// Header and rows without the caption, cells separated by tabs, for a
// spreadsheet. Minus signs are hyphens there.
std::string RenderTabbed(const Table& table);

// A <table> with <caption>, <thead> and <tbody>, scope attributes and
// everything escaped. Alignment is by the classes left, center and right,
// levels by level-1 to level-4. Cells that are a date are not broken (class
// date).
std::string RenderHtml(const Table& table);

// The handlers in the markup, unescaped.
std::string_view SortScript();

}  // namespace mle::report

#endif  // APPS_REPORT_TABLE_H_
