// How wide text is in DejaVu Sans, the font of the figures.

#ifndef APPS_REPORT_FONT_H_
#define APPS_REPORT_FONT_H_

#include <string>
#include <string_view>

namespace mle::report {

inline constexpr char kFont[] = "DejaVu Sans";

// In units of the font size; characters beyond ASCII are taken a little wider
// than they are.
double TextWidth(std::string_view text);

// CleanText(text), cut and ended with "…" where it is wider than `width` (in
// units of the font size).
std::string Ellipsized(std::string_view text, double width);

}  // namespace mle::report

#endif  // APPS_REPORT_FONT_H_
