#include "apps/report/table.h"

#include <sstream>
#include <string>

#include "apps/report/text.h"
#include "gtest/gtest.h"

namespace mle::report {
namespace {

Table ExampleTable() {
  Table table{
      .caption = "Errors",
      .columns = {{"case", Align::kLeft}, {"E"}, {"ok", Align::kCenter}}};
  table.AddRow({"gain", "8.1", "yes"});
  table.AddRow({"delay λ", "1,594", "–"});
  return table;
}

TEST(RenderText, AlignsColumns) {
  EXPECT_EQ(RenderText(ExampleTable()),
            "Errors\n"
            "case         E  ok\n"
            "───────  ─────  ───\n"
            "gain       8.1  yes\n"
            "delay λ  1,594   –\n");
}

TEST(RenderText, WideCharactersKeepTheColumnsStraight) {
  Table table{.columns = {{"tag", Align::kLeft}, {"value"}}};
  table.AddRow({"温度計", "1"});
  table.AddRow({"e\u0301tage", "22"});
  table.AddRow({"a\nb", "333"});
  std::istringstream lines(RenderText(table));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_EQ(DisplayWidth(line), 6 + 2 + 5) << line;
  }
  EXPECT_EQ(count, 5);  // header, rule, rows: none was broken
}

TEST(RenderText, NoCellIsLostInRaggedRows) {
  Table table{.columns = {{"a", Align::kLeft}}};
  table.AddRow({});
  table.AddRow({"x", "beyond"});
  EXPECT_EQ(RenderText(table),
            "a\n"
            "─  ──────\n"
            "\n"
            "x  beyond\n");
}

TEST(RenderHtml, DatesAreNotBrokenOverLines) {
  Table table{.columns = {{"a"}, {"when", Align::kLeft}, {"b", Align::kLeft}}};
  table.AddRow(
      {"1", "2024-03-04 06:00", "2024-03-04 is the day of the change"});
  const std::string html = RenderHtml(table);
  EXPECT_NE(html.find("class=\"left date\">2024-03-04 06:00<"),
            std::string::npos);
  EXPECT_NE(html.find("class=\"left\">2024-03-04 is"), std::string::npos);
  table.rows = {{"1", "2024-3-04", "20240304"}};
  EXPECT_EQ(RenderHtml(table).find("date\""), std::string::npos);
}

// A stacked table shows the header of each cell, and a row of one level has it
// as a whole.
TEST(RenderHtml, CellsThatAreStackedHaveTheirHeaders) {
  Table table{.columns = {{"output"}, {"gain"}}};
  table.AddRow({"y", "2"});
  table.AddRow({"z", "3"});
  table.levels = {{2, 2}, {0, 1}};
  EXPECT_EQ(RenderHtml(table).find("data-label"), std::string::npos);
  table.stacked = true;
  const std::string html = RenderHtml(table);
  EXPECT_NE(html.find("<tr class=\"level-2\">"), std::string::npos);
  EXPECT_NE(html.find("class=\"right\" data-label=\"gain\">2<"),
            std::string::npos);
  EXPECT_NE(html.find("<tr><th"), std::string::npos);
  EXPECT_NE(html.find("class=\"right level-1\" data-label=\"gain\">3<"),
            std::string::npos);
}

TEST(RenderHtml, HasCaptionScopesAndAlignment) {
  EXPECT_EQ(RenderHtml(ExampleTable()),
            "<table>\n<caption>Errors</caption>\n<thead>\n"
            "<tr><th scope=\"col\" class=\"left\">case</th>"
            "<th scope=\"col\" class=\"right\">E</th>"
            "<th scope=\"col\" class=\"center\">ok</th></tr>\n"
            "</thead>\n<tbody>\n"
            "<tr><th scope=\"row\" class=\"left\">gain</th>"
            "<td class=\"right\">8.1</td><td class=\"center\">yes</td></tr>\n"
            "<tr><th scope=\"row\" class=\"left\">delay λ</th>"
            "<td class=\"right\">1,594</td><td class=\"center\">–</td></tr>\n"
            "</tbody>\n</table>\n");
}

TEST(RenderHtml, EscapesEverything) {
  Table table{.caption = "<c>", .columns = {{"<h>"}}, .row_headers = false};
  table.AddRow({"<script>alert('x')</script>"});
  const std::string html = RenderHtml(table);
  EXPECT_NE(html.find("<caption>&lt;c&gt;</caption>"), std::string::npos);
  EXPECT_NE(html.find(">&lt;h&gt;</th>"), std::string::npos);
  EXPECT_NE(
      html.find("<td class=\"right\">&lt;script&gt;alert(&#39;x&#39;)&lt;"),
      std::string::npos);
}

}  // namespace
}  // namespace mle::report
