#include "apps/report/table.h"

#include <sstream>
#include <string>

#include "apps/report/text.h"
#include "gtest/gtest.h"

namespace mle::report {
namespace {

Table Example() {
  Table table{
      .caption = "Errors",
      .columns = {{"case", Align::kLeft}, {"E"}, {"ok", Align::kCenter}}};
  table.AddRow({"gain", "8.1", "yes"});
  table.AddRow({"delay λ", "1,594", "–"});
  return table;
}

TEST(RenderText, AlignsColumns) {
  EXPECT_EQ(RenderText(Example()),
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

TEST(RenderHtml, HasCaptionScopesAndAlignment) {
  EXPECT_EQ(RenderHtml(Example()),
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
