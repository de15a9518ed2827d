#include "apps/report/svg.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/report/markup.h"

namespace mle::report {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kSvg[] = R"svg(<?xml version="1.0"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "svg11.dtd">
<!-- a <comment> -->
<svg width="400" height="300" viewBox="0 0 400 300"
  xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">
<title>Gnuplot</title>
<desc>Produced by <b>GNUPLOT</b></desc>
<defs><circle id='dot' r='1'/></defs>
<g id="canvas" clip-path="url(#clip)"><title>x</title>
<use xlink:href='#dot' x="1"/><text>a id='dot' &lt; 2 &gt; 1</text></g>
</svg>
trailing)svg";

TEST(EmbedSvg, KeepsThePictureAndPrefixesItsIds) {
  const auto svg = EmbedSvg(kSvg, "f1-", "a \"figure\" <1>");
  ASSERT_TRUE(svg.ok()) << svg.status();
  const Markup markup = ParseMarkup(*svg);
  ASSERT_EQ(markup.error, "");
  EXPECT_TRUE(svg->starts_with("<svg"));
  EXPECT_THAT(markup.Values("id"), ElementsAre("f1-dot", "f1-canvas"));
  EXPECT_THAT(markup.Values("xlink:href"), ElementsAre("#f1-dot"));
  EXPECT_THAT(markup.Values("clip-path"), ElementsAre("url(#f1-clip)"));
  EXPECT_THAT(markup.Texts("text"), ElementsAre("a id='dot' < 2 > 1"));
  EXPECT_EQ(markup.Count("title") + markup.Count("desc"), 0);
}

TEST(EmbedSvg, FollowsTheWidthOfThePage) {
  const Markup markup = ParseMarkup(*EmbedSvg(kSvg, "p", "a \"figure\" <1>"));
  const auto& attributes = markup.elements[0].attributes;
  EXPECT_EQ(attributes.count("width"), 0u);
  EXPECT_EQ(attributes.count("height"), 0u);
  EXPECT_EQ(attributes.at("viewBox"), "0 0 400 300");
  EXPECT_EQ(attributes.at("style"), "max-width:560px;min-width:340px");
  EXPECT_EQ(attributes.at("role"), "img");
  EXPECT_EQ(attributes.at("aria-label"), "a \"figure\" <1>");
}

TEST(EmbedSvg, RefusesWhatIsNoPicture) {
  for (const char* text :
       {"", "hello", "<html></html>", "<svg", "<svg viewBox='0 0 1 1'>",
        "<svg></svg>", "<svg viewBox='0 0 x'></svg>",
        "<svg viewBox='0 0 -1 1'></svg>", "<svg viewBox=0></svg>",
        "<svg viewBox='0 0 1 1' a></svg>", "<!-- <svg>", "<svg a='1>"}) {
    EXPECT_EQ(EmbedSvg(text, "", "").status().code(),
              absl::StatusCode::kInvalidArgument)
        << text;
  }
}

TEST(EmbedSvg, RefusesAnythingActive) {
  for (const char* inside :
       {"<script>x()</script>", "<g onload='x()'/>",
        "<foreignObject></foreignObject>", "<style>@import 'x'</style>",
        "<a xlink:href='javascript:x()'></a>", "<use href='http://x/#y'/>",
        "<image xlink:href='#y'/>"}) {
    const auto svg = EmbedSvg(
        "<svg viewBox='0 0 9 9'>" + std::string(inside) + "</svg>", "", "");
    EXPECT_EQ(svg.status().code(), absl::StatusCode::kInvalidArgument)
        << inside;
    EXPECT_THAT(std::string(svg.status().message()), HasSubstr("no SVG"));
  }
}

}  // namespace
}  // namespace mle::report
