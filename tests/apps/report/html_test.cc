#include "apps/report/html.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/report/figure.h"
#include "apps/report/gnuplot.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/report/markup.h"

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

absl::StatusOr<std::string> Svg(const Figure& figure) {
  return RenderFigure(figure, Format::kSvg);
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
  const Figure figure = Drawing(text);
  page.AddFigure(figure, Svg(figure), text, text);
  page.AddFigure(figure, Svg(figure), text, text);
  page.AddFigure(figure, absl::InternalError(text), text, text);
  page.AddCode(text);
  page.AddFiles({{text, text}});
  page.AddRunAgain({.command = text,
                    .version = text,
                    .seeds = text,
                    .more = {{text, text}}});
  return page;
}

TEST(HtmlPage, IsWellFormed) {
  const Markup markup = ParseMarkup(FullPage("E < 10 & λ > 0").Render(), true);
  EXPECT_EQ(markup.error, "");
  EXPECT_EQ(markup.Count("svg"), 2);
  EXPECT_EQ(markup.Count("h1"), 1);
  EXPECT_THAT(markup.Texts("title"), ElementsAre("E < 10 & λ > 0"));
  EXPECT_THAT(markup.Values("lang"), ElementsAre("en"));
}

TEST(HtmlPage, EscapesEverything) {
  const std::string html = FullPage(kHostile).Render();
  const Markup markup = ParseMarkup(html, true);
  EXPECT_EQ(markup.error, "");
  // Three figures' data, and what draws them.
  EXPECT_EQ(markup.Count("script"), 5);
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
  // Besides names of vocabularies and the licence of the charts' library, no
  // address.
  for (std::size_t at = 0; (at = html.find("://", at)) != std::string::npos;
       ++at) {
    EXPECT_TRUE(html.substr(at, 14) == "://www.w3.org/" ||
                html.substr(at, 26) == "://github.com/danvk/dygrap")
        << html.substr(at, 40);
  }
}

TEST(HtmlPage, IdsAreUniqueAndReferencesMeet) {
  const Markup markup = ParseMarkup(FullPage("text").Render(), true);
  const std::vector<std::string> all = markup.Values("id");
  const std::set<std::string> ids(all.begin(), all.end());
  EXPECT_EQ(ids.size(), all.size());
  std::vector<std::string> references = markup.Values("xlink:href");
  EXPECT_FALSE(references.empty());
  for (const std::string& target : markup.Values("href")) {
    if (target.starts_with("#")) references.push_back(target);
  }
  for (const std::string& reference : references) {
    EXPECT_TRUE(ids.contains(reference.substr(1))) << reference;
  }
}

TEST(HtmlPage, AMissingFigureIsAWarningWithTheReason) {
  HtmlPage page("p");
  page.AddFigure(Drawing("true"),
                 absl::FailedPreconditionError("gnuplot is not installed"),
                 "Error over λ", "alt");
  page.AddFigure(Figure(), std::string("no svg"), "Second", "alt");
  const Markup markup = ParseMarkup(page.Render(), true);
  // The first has its chart nevertheless.
  EXPECT_EQ(markup.Count("figure"), 1);
  EXPECT_THAT(
      markup.Texts("p"),
      ElementsAre(HasSubstr("The picture of figure 1 (Error over λ) is "
                            "missing: gnuplot is not installed"),
                  HasSubstr("The picture of figure 2 (Second) is missing: the "
                            "picture is no SVG")));
}

TEST(HtmlPage, AMapOfCellsIsAPictureOnly) {
  Figure map;
  map.AddPanel("").cells.push_back({0.0, 0.0, 0.5, {"gain"}});
  HtmlPage page("Map");
  page.AddFigure(map,
                 std::string("<svg xmlns=\"http://www.w3.org/2000/svg\" "
                             "width=\"10\" height=\"10\" "
                             "viewBox=\"0 0 10 10\"></svg>"),
                 "A map.", "A map.");
  const std::string html = page.Render();
  EXPECT_NE(html.find("<svg"), std::string::npos);
  EXPECT_EQ(html.find("class=\"chart-data\""), std::string::npos);
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

TEST(HtmlPage, SamePageSameBytes) {
  EXPECT_EQ(FullPage("text").Render(), FullPage("text").Render());
}

}  // namespace
}  // namespace mle::report
