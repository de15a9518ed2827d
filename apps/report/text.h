// Text that comes from outside (channel names, file names, messages) made safe
// for the place it is shown in.

#ifndef APPS_REPORT_TEXT_H_
#define APPS_REPORT_TEXT_H_

#include <string>
#include <string_view>
#include <vector>

namespace mle::report {

// `text` as valid UTF-8 that may stand in XML: bytes that are no UTF-8 become
// U+FFFD, control characters (newlines among them) a space.
std::string CleanText(std::string_view text);

// The code points of CleanText(text).
std::vector<char32_t> CodePoints(std::string_view text);

// The code point as UTF-8.
std::string Utf8(char32_t code_point);

// CleanText, and & < > " ' as entities: safe in the text and in the quoted
// attributes of HTML and XML.
std::string EscapeHtml(std::string_view text);

// With blanks that do not break between a number and its sign: "95 %", "± 2",
// "× 0.5", "← reflux".
std::string WithSignsKept(std::string_view text);

// A path beside the page as the target of a link: "%" before what a URL would
// read as something else, "./" so that no scheme can be meant.
std::string RelativeUrl(std::string_view path);

// As EscapeHtml, but newlines and tabs stay: for <pre>.
std::string EscapeHtmlLines(std::string_view text);

// Columns `text` takes on a terminal: 0 for combining marks, 2 for East Asian
// wide characters and emoji, else 1.
int DisplayWidth(std::string_view text);

// The arguments as one line that a POSIX shell reads back as the same
// arguments: {"mle_correct", "--out=my dir"} gives mle_correct '--out=my dir'.
std::string QuoteCommandLine(const std::vector<std::string>& arguments);

// The font of the figures, and how wide text is in it.
inline constexpr char kFont[] = "DejaVu Sans";

// In units of the font size; characters beyond ASCII are taken a little wider
// than they are.
double TextWidth(std::string_view text);

// CleanText(text), cut and ended with "…" where it is wider than `width` (in
// units of the font size).
std::string Ellipsized(std::string_view text, double width);

}  // namespace mle::report

#endif  // APPS_REPORT_TEXT_H_
