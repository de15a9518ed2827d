#include "apps/report/text.h"

#include <string>

#include "gtest/gtest.h"

namespace mle::report {
namespace {

TEST(CleanText, KeepsText) {
  const std::string text = "T_distillate [°C] λ φ₁₁ 温度 😀 'a' \"b\" \\n";
  EXPECT_EQ(CleanText(text), text);
}

TEST(CleanText, ControlCharactersBecomeBlanks) {
  EXPECT_EQ(CleanText(std::string("a\0b\nc\x1b[31m\x7f", 11)), "a b c [31m ");
  EXPECT_EQ(CleanText("a\u202Eb\u2028c\u0085d"), "a b c d");
}

TEST(CleanText, BrokenUtf8IsReplaced) {
  EXPECT_EQ(CleanText("a\xFFz"), "a\uFFFDz");
  EXPECT_EQ(CleanText("\xC3"), "\uFFFD");            // cut off
  EXPECT_EQ(CleanText("\xC0\xAF"), "\uFFFD\uFFFD");  // overlong
  EXPECT_EQ(CleanText("\xE0\x80\xAF"), "\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(CleanText("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // surrogate
  EXPECT_EQ(CleanText("\xF4\x90\x80\x80"),
            "\uFFFD\uFFFD\uFFFD\uFFFD");     // beyond U+10FFFF
  EXPECT_EQ(CleanText("\uFFFE"), "\uFFFD");  // forbidden in XML
}

TEST(CleanText, IsIdempotentOnEveryPairOfBytes) {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      const std::string text = {static_cast<char>(a), static_cast<char>(b)};
      const std::string clean = CleanText(text);
      ASSERT_EQ(CleanText(clean), clean) << a << " " << b;
    }
  }
}

TEST(Utf8, IsTheInverseOfCodePoints) {
  for (const char32_t code : {U'a', U'\u00E9', U'\u20AC', U'\U0001F600'}) {
    const auto points = CodePoints(Utf8(code));
    ASSERT_EQ(points.size(), 1u);
    EXPECT_EQ(points[0], code);
  }
}

TEST(EscapeHtml, LeavesNothingThatIsMarkup) {
  EXPECT_EQ(EscapeHtml("<a href=\"x\" id='y'>&amp;</a>\n"),
            "&lt;a href=&quot;x&quot; id=&#39;y&#39;&gt;&amp;amp;&lt;/a&gt; ");
}

TEST(EscapeHtmlLines, KeepsNewlinesAndTabs) {
  EXPECT_EQ(EscapeHtmlLines("a\n\tb <\r\n"), "a\n\tb &lt; \n");
}

TEST(DisplayWidth, CountsColumns) {
  EXPECT_EQ(DisplayWidth(""), 0);
  EXPECT_EQ(DisplayWidth("λ = 10⁻³"), 8);
  EXPECT_EQ(DisplayWidth("温度"), 4);
  EXPECT_EQ(DisplayWidth("e\u0301"), 1);  // e and a combining accent
  EXPECT_EQ(DisplayWidth("😀"), 2);
}

TEST(QuoteCommandLine, QuotesWhatAShellWouldRead) {
  EXPECT_EQ(QuoteCommandLine({"mle_correct", "--data=a.csv,b.csv"}),
            "mle_correct --data=a.csv,b.csv");
  EXPECT_EQ(QuoteCommandLine({"x", "", "a b", "$(id)", "it's", "~"}),
            "x '' 'a b' '$(id)' 'it'\\''s' '~'");
}

}  // namespace
}  // namespace mle::report
