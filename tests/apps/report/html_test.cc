#include "apps/report/html.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "apps/report/figure.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/report/markup.h"
#include "tests/apps/report/shown_figures.h"

namespace mle::report {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kHostile[] =
    "</p></title><script>alert(\"x\")</script>'\"&amp; \n onload=x";

Figure Drawing(const std::string& label) {
  Figure figure;
  Panel& panel = figure.AddPanel("gain");
  panel.series.push_back(
      MakeSeries(Role::kTrue, label, {0.0, 1.0}, {0.0, 1.0}));
  panel.markers.push_back(MakeMarker(Role::kBest, "best", 0.5, 0.5));
  return figure;
}

HtmlPage FullPage(const std::string& text) {
  HtmlPage page(text);
  page.AddSummary({text, text});
  page.AddHeading(text);
  page.AddSubheading(text);
  page.AddParagraph(text);
  page.AddList({text});
  page.AddWarning(text);
  Table table{.caption = text, .columns = {{text}, {text}}};
  table.AddRow({text, text});
  page.AddTable(table);
  page.AddHeading(text);
  page.AddFigure(Drawing(text), text, text);
  page.AddFigure(Drawing(text), text, text);
  page.AddFigure(Figure(), text, text);
  page.AddCode(text);
  page.AddFiles({{text, text}});
  page.AddRunAgain({.command = text,
                    .version = text,
                    .seeds = text,
                    .more = {{text, text}}});
  return page;
}

TEST(HtmlPage, NamesOfFlagsAreNotBroken) {
  HtmlPage page("Flags");
  page.AddParagraph("Give --leave_out=12 or -- (--max_delay), not a--.");
  EXPECT_THAT(page.Render(),
              HasSubstr("<p>Give <span class=\"flag\">--leave_out</span>=12 or "
                        "-- (<span class=\"flag\">--max_delay</span>), not "
                        "a--.</p>"));
}

TEST(HtmlPage, IsWellFormed) {
  const Markup markup = ParseMarkup(FullPage("E < 10 & λ > 0").Render(), true);
  EXPECT_EQ(markup.error, "");
  EXPECT_EQ(markup.Count("figure"), 2);
  EXPECT_EQ(markup.Count("h1"), 1);
  EXPECT_EQ(markup.Texts("title").at(0), "E < 10 & λ > 0");
  EXPECT_THAT(markup.Values("lang"), ElementsAre("en"));
}

TEST(HtmlPage, EscapesEverything) {
  const std::string html = FullPage(kHostile).Render();
  const Markup markup = ParseMarkup(html, true);
  EXPECT_EQ(markup.error, "");
  EXPECT_EQ(markup.Count("script"), 1);  // ours
  EXPECT_TRUE(markup.Values("onload").empty());
}

TEST(HtmlPage, NeedsNothingFromOutside) {
  const std::string html = FullPage("text").Render();
  const Markup markup = ParseMarkup(html, true);
  for (const char* element : {"link", "img", "iframe", "object"}) {
    EXPECT_EQ(markup.Count(element), 0) << element;
  }
  EXPECT_TRUE(markup.Values("src").empty());
  for (const std::string& target : markup.Values("href")) {
    EXPECT_TRUE(target.starts_with("#") || target.starts_with("./")) << target;
  }
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  // Besides the name of SVG, no address.
  for (std::size_t at = 0; (at = html.find("://", at)) != std::string::npos;
       ++at) {
    EXPECT_EQ(html.substr(at, 14), "://www.w3.org/");
  }
}

TEST(HtmlPage, IdsAreUniqueAndReferencesMeet) {
  const Markup markup = ParseMarkup(FullPage("text").Render(), true);
  const std::vector<std::string> all = markup.Values("id");
  const std::set<std::string> ids(all.begin(), all.end());
  EXPECT_EQ(ids.size(), all.size());
  std::vector<std::string> references;
  for (const std::string& target : markup.Values("href")) {
    if (target.starts_with("#")) references.push_back(target);
  }
  for (const std::string& reference : references) {
    EXPECT_TRUE(ids.contains(reference.substr(1))) << reference;
  }
}

TEST(HtmlPage, AFigureThatCannotBeDrawnIsAWarning) {
  HtmlPage page("p");
  page.AddFigure(Drawing("true"), "Error over λ", "alt");
  page.AddFigure(Figure(), "Second", "alt");
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_EQ(markup.Count("figure"), 1);
  EXPECT_THAT(markup.Texts("figcaption"),
              ElementsAre("Figure 1. Error over λ"));
  EXPECT_THAT(markup.Texts("p"),
              ElementsAre(HasSubstr("Figure 2 (Second) is missing: figure: it "
                                    "has no panel")));
}

TEST(HtmlPage, IsWholeWithoutScripts) {
  HtmlPage page("p");
  page.AddFigure(Drawing("true"), "Error over λ", "alt");
  std::string html = page.Render();
  const std::size_t script = html.find("<script>");
  html.erase(script, html.find("</script>") + 9 - script);
  const std::vector<ShownFigure> figures = FiguresOf(html, true);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].panels.at(0).series.size(), 2u);
  EXPECT_THAT(figures[0].texts, ::testing::IsSupersetOf({"gain", "true"}));
}

TEST(HtmlPage, ListsItsSectionsFromThreeOn) {
  HtmlPage page("p");
  page.AddHeading("one");
  page.AddHeading("two");
  EXPECT_EQ(ParseMarkup(page.Render(), true).Count("nav"), 0);
  page.AddHeading("three");
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_EQ(markup.Count("nav"), 1);
  EXPECT_THAT(markup.Texts("a"), ElementsAre("one", "two", "three"));
}

TEST(HtmlPage, LinksLeadToFilesBesideThePage) {
  HtmlPage page("p");
  page.AddFiles({{"figure", "figures/e λ.pdf"}, {"x", "javascript:x()"}});
  EXPECT_THAT(
      ParseMarkup(page.Render(), true).Values("href"),
      ElementsAre("./figures/e%20%CE%BB.pdf", "./javascript%3Ax%28%29"));
}

TEST(HtmlPage, SaysHowToRunItAgain) {
  HtmlPage page("p");
  page.AddRunAgain({.command = "mle_reproduce \\\n  --seeds=20", .seeds = "1"});
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_THAT(markup.Texts("code"),
              ElementsAre("mle_reproduce \\\n  --seeds=20"));
  EXPECT_THAT(markup.Texts("dt"), ElementsAre("Seeds"));  // no version given
  EXPECT_THAT(markup.Texts("h2"), Contains("Run it again"));
}

TEST(HtmlPage, ATableCanBeSearched) {
  HtmlPage page("p");
  Table table{.caption = "t",
              .columns = {{"name", Align::kLeft}, {"state", Align::kLeft}},
              .searchable = true,
              .choice = 1};
  table.AddRow({"a", "b<c"});
  table.AddRow({"d", "b<c"});
  table.AddRow({"e", "f"});
  page.AddTable(table);
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_EQ(markup.error, "");
  EXPECT_THAT(markup.Texts("option"), ElementsAre("all", "b<c", "f"));
  EXPECT_THAT(markup.Texts("output"), ElementsAre("3 of 3"));
  EXPECT_THAT(markup.Values("oninput"), ElementsAre(PageScripts()[2]));
}

TEST(HtmlPage, AFormIsPosted) {
  HtmlPage page("p");
  page.AddForm(
      {.action = "/a",
       .submit = "Do & go",
       .fields = {
           {.name = "x", .kind = Form::Field::Kind::kHidden, .value = "\"><b>"},
           {.name = "y", .label = "Why", .required = true}}});
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_EQ(markup.error, "");
  EXPECT_THAT(markup.Values("method"), ElementsAre("post"));
  EXPECT_THAT(markup.Values("name"), ::testing::IsSupersetOf({"x", "y"}));
  EXPECT_THAT(markup.Values("value"), ElementsAre("\"><b>"));
  EXPECT_THAT(markup.Texts("button"), ElementsAre("Do & go"));
}

// A server allows these and no others.
TEST(HtmlPage, AllScriptsAreListed) {
  HtmlPage page("p");
  Table table{.columns = {{"name"}}, .sortable = true, .searchable = true};
  table.AddRow({"a"});
  page.AddTableToCopy(table, table);
  page.AddFigure(Drawing("true"), "c", "alt");
  const Markup markup = ParseMarkup(page.Render(), true);
  const std::vector<std::string_view> known = PageScripts();
  for (const char* attribute : {"onclick", "oninput"}) {
    for (const std::string& script : markup.Values(attribute)) {
      EXPECT_THAT(known, ::testing::Contains(script));
    }
  }
  // The one of figures stands in an element of its own.
  EXPECT_EQ(markup.Count("script"), 1);
  EXPECT_THAT(page.Render(),
              HasSubstr("<script>" + std::string(known[3]) + "</script>"));
}

// So that a reader who opens no fold finds no number missing.
TEST(HtmlPage, FiguresOutsideFoldsAreNumberedFirst) {
  HtmlPage page("p");
  page.AddFigure(Drawing("true"), "first", "alt");
  page.OpenFold("more");
  page.AddFigure(Drawing("true"), "folded", "alt");
  page.CloseFold();
  page.AddFigure(Drawing("true"), "second", "alt");
  const std::string html = page.Render();
  EXPECT_THAT(html, HasSubstr("Figure 1. first"));
  EXPECT_THAT(html, HasSubstr("Figure 2. second"));
  EXPECT_THAT(html, HasSubstr("Figure 3. folded"));
  EXPECT_EQ(html.find('\x1A'), std::string::npos);
}

// Panels side by side would be cut on a telephone.
TEST(HtmlPage, PanelsSideBySideAreShownBelowEachOtherOnANarrowPage) {
  Figure figure = Drawing("true");
  figure.AddPanel("other").series.push_back(
      MakeSeries(Role::kTrue, "true", {0.0, 1.0}, {0.0, 1.0}));
  figure.columns = 2;
  HtmlPage page("p");
  page.AddFigure(figure, "c", "alt");
  page.OpenFold("more");
  page.AddFigure(figure, "folded", "alt");
  page.CloseFold();
  const Markup markup = ParseMarkup(page.Render(), true);
  EXPECT_EQ(markup.error, "");
  int wide = 0;
  int narrow = 0;
  for (const std::string& css : markup.Values("class")) {
    if (css == "scroll picture wide") ++wide;
    if (css == "scroll picture narrow") ++narrow;
  }
  EXPECT_EQ(wide, 1);
  EXPECT_EQ(narrow, 1);
}

TEST(HtmlPage, NumbersAreNotBrokenFromTheirSigns) {
  HtmlPage page("p");
  page.AddParagraph("a 95 % interval, ± 2, and a % alone");
  EXPECT_THAT(page.Render(),
              HasSubstr("a 95\u00A0% interval, ±\u00A02, and a % alone"));
}

TEST(HtmlPage, SamePageSameBytes) {
  EXPECT_EQ(FullPage("text").Render(), FullPage("text").Render());
}

}  // namespace
}  // namespace mle::report
